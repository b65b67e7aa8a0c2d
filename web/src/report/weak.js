import { element } from './dom.js';

const AXES = { x: { to: [62, 6], label: 'x right' }, y: { to: [0, 58], label: 'y down' }, z: { to: [-42, -34], label: 'z forward' } };
const SVG = 'http://www.w3.org/2000/svg';

function svg(tag, attributes, text) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  if (text) node.textContent = text;
  return node;
}

/** Names of components in texts such as "rotation y + translation x". */
function weakComponents(directions) {
  const components = new Set();
  for (const match of directions.join(' + ').matchAll(/(rotation|translation) ([xyz])/g)) components.add(`${match[1]} ${match[2]}`);
  return components;
}

/** The axes of the camera; a direction that the photo's own edges do not determine is drawn bold and red: a double arrow
 *  for a translation, an arc around the axis for a rotation. */
export function weakDrawing(image) {
  const weak = weakComponents(image.weak_directions);
  const drawing = svg('svg', { viewBox: '-85 -62 175 140', class: 'axes', role: 'img', 'aria-label': 'axes of the camera' });
  for (const [axis, { to: [x, y], label }] of Object.entries(AXES)) {
    const moves = weak.has(`translation ${axis}`);
    const turns = weak.has(`rotation ${axis}`);
    const from = moves ? [-x * 0.55, -y * 0.55] : [0, 0];
    drawing.append(svg('line', { x1: from[0], y1: from[1], x2: x, y2: y, class: moves ? 'weak' : '' }));
    const angle = (Math.atan2(y, x) * 180) / Math.PI;
    const arrow = (px, py, turn) => svg('path', { d: 'M0 0 L-8 -4 L-8 4 Z', transform: `translate(${px} ${py}) rotate(${turn})`, class: moves ? 'weak' : '' });
    drawing.append(arrow(x, y, angle));
    if (moves) drawing.append(arrow(from[0], from[1], angle + 180));
    if (turns) drawing.append(svg('ellipse', { cx: 0, cy: 0, rx: 5, ry: 13, transform: `translate(${x * 0.6} ${y * 0.6}) rotate(${angle})`, class: 'weak' }));
    drawing.append(svg('text', { x: x * 1.12, y: y * 1.12 + 4, 'text-anchor': x < 0 ? 'end' : 'start', class: moves || turns ? 'weak' : '' }, label));
  }
  const text = image.weak_directions.length ? `Weak: ${image.weak_directions.join(', ')}` : 'No weak direction: the photo sees enough structure all around.';
  return element('div', { class: 'weak-box' }, drawing, element('p', { class: 'hint' }, text));
}
