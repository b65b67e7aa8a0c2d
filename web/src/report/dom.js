/** An element with attributes (functions are listeners) and children (text or elements). */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') node.addEventListener(name, value);
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(name, value === true ? '' : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

export const checkbox = (label, checked, change) => {
  const input = element('input', { type: 'checkbox', change: () => change(input.checked) });
  input.checked = checked;
  return element('label', {}, input, label);
};
