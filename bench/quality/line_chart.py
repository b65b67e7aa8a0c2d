"""Lines through points of two shares, with some of the points marked, as an SVG file."""

import math
from dataclasses import dataclass

import bar_chart

WIDTH_PX, HEIGHT_PX = 700, 440
LEFT_PX, RIGHT_PX, TOP_PX, BOTTOM_PX = 62, 24, 52, 52
TEXT_PX = 13
# Where the label of a mark stands from it, for the first line and the second: on sides that face away from each other.
LABEL_STEPS_PX = ((5, -8, "start"), (-6, 16, "end"))


@dataclass(frozen=True)
class Line:
    name: str
    color: str
    points: list  # (x, y), both shares of 0 to 1
    marks: list  # (x, y, label)


class Axes:
    """Pixel place of two shares: x from 0 to 1, y from `bottom` to 1."""

    def __init__(self, bottom):
        self.bottom = bottom

    def x(self, share):
        return LEFT_PX + (WIDTH_PX - LEFT_PX - RIGHT_PX) * share

    def y(self, share):
        return TOP_PX + (HEIGHT_PX - TOP_PX - BOTTOM_PX) * (1.0 - share) / (1.0 - self.bottom)


def axis_bottom(lines):
    """The tenth below all values; never so high that there is no axis left."""
    lowest = min(y for line in lines for _, y in line.points)
    return min(math.floor(10.0 * lowest), 8) / 10.0


def grid(axes, x_title, y_title):
    right, bottom = WIDTH_PX - RIGHT_PX, HEIGHT_PX - BOTTOM_PX
    parts = []
    for tenth in range(0, 11, 2):
        x = axes.x(tenth / 10)
        parts.append(f'<path d="M{x:.1f} {TOP_PX}V{bottom}" stroke="#ddd" fill="none"/>')
        parts.append(bar_chart.text(x, bottom + 18, f"{10 * tenth} %", size=TEXT_PX))
    step = 1 if axes.bottom >= 0.5 else 2
    for tenth in range(10, round(10 * axes.bottom) - 1, -step):
        y = axes.y(tenth / 10)
        parts.append(f'<path d="M{LEFT_PX} {y:.1f}H{right}" stroke="#ddd" fill="none"/>')
        parts.append(bar_chart.text(LEFT_PX - 6, y + 4, f"{10 * tenth} %", "end", TEXT_PX))
    parts.append(f'<path d="M{LEFT_PX} {TOP_PX}V{bottom}H{right}" stroke="#333" fill="none"/>')
    parts.append(bar_chart.text(0.5 * (LEFT_PX + right), HEIGHT_PX - 12, x_title, size=TEXT_PX))
    parts.append(f'<g transform="rotate(-90 16 {0.5 * (TOP_PX + bottom):.1f})">'
                 + bar_chart.text(16, 0.5 * (TOP_PX + bottom), y_title, size=TEXT_PX) + "</g>")
    return parts


def path_element(line, axes):
    places = " ".join(f"{axes.x(x):.1f},{axes.y(y):.1f}" for x, y in line.points)
    return f'<polyline points="{places}" stroke="{line.color}" stroke-width="2" fill="none"/>'


def mark_elements(line, axes, label_step):
    step_x, step_y, anchor = label_step
    parts = ['<g stroke="#fff" stroke-width="3" paint-order="stroke">']  # labels stay readable where a line passes
    for x, y, label in line.marks:
        x_px, y_px = axes.x(x), axes.y(y)
        parts.append(f'<circle cx="{x_px:.1f}" cy="{y_px:.1f}" r="4.5" stroke-width="1" fill="{line.color}"/>')
        parts.append(bar_chart.text(x_px + step_x, y_px + step_y, label, anchor, 12, line.color))
    return [*parts, "</g>"]


def legend(lines):
    parts, x = [], LEFT_PX
    for line in lines:
        parts.append(f'<path d="M{x:.1f} 37H{x + 20:.1f}" stroke="{line.color}" stroke-width="3" fill="none"/>')
        parts.append(bar_chart.text(x + 26, 41, line.name, "start", TEXT_PX))
        x += 50 + 7.0 * len(line.name)
    return parts


def svg(title, x_title, y_title, lines):
    """One or two `lines`, each with at least one point."""
    axes = Axes(axis_bottom(lines))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH_PX}" height="{HEIGHT_PX}" '
             f'viewBox="0 0 {WIDTH_PX} {HEIGHT_PX}" font-family="sans-serif">',
             f'<rect width="{WIDTH_PX}" height="{HEIGHT_PX}" fill="#fff"/>',
             bar_chart.text(LEFT_PX, 20, title, "start", 15), *legend(lines), *grid(axes, x_title, y_title)]
    parts += [path_element(line, axes) for line in lines]
    for line, label_step in zip(lines, LABEL_STEPS_PX):
        parts += mark_elements(line, axes, label_step)
    return "\n".join(parts + ["</svg>"]) + "\n"
