#!/usr/bin/env python3
"""Draws what scale.py measured: CPU time a point and memory of each command over the points of the map, as one SVG.

plot_scale.py OUT.svg SCALE.json ...: the rows of all files make one line a command. Needs nothing but Python's standard
library."""

import argparse
import json
import math
import pathlib

COMMANDS = (("index", "index", "#1f5fa8"), ("refine_again", "refine", "#c2571a"), ("colorize", "colorize", "#3b8a3e"))
WIDTH, HEIGHT = 360, 250  # of a panel
LEFT, TOP, BOTTOM = 56, 34, 44


def powers(low, high):
    """Powers of ten around [low, high]."""
    return [10.0 ** e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]


def number(value):
    return f"{value:,.0f}" if value >= 1 else f"{value:g}"


class Panel:
    """A plot with logarithmic axes; `lines`: (name, colour, [(x, y), ...])."""

    def __init__(self, x0, title, x_title, lines, limit=None):
        self.x0, self.title, self.x_title, self.lines, self.limit = x0, title, x_title, lines, limit
        points = [point for _, _, some in lines for point in some]
        self.x_ticks = powers(min(x for x, _ in points), max(x for x, _ in points))
        y_values = [y for _, y in points] + ([limit] if limit else [])
        self.y_ticks = powers(min(y_values), max(y_values))

    def place(self, x, y):
        def share(value, ticks):
            return math.log10(value / ticks[0]) / math.log10(ticks[-1] / ticks[0])
        width, height = WIDTH - LEFT - 12, HEIGHT - TOP - BOTTOM
        return self.x0 + LEFT + share(x, self.x_ticks) * width, TOP + (1 - share(y, self.y_ticks)) * height

    def line(self, begin, end, color, more=""):
        (x1, y1), (x2, y2) = self.place(*begin), self.place(*end)
        return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{color}" {more}/>'

    def draw(self):
        parts = [f'<text x="{self.x0 + LEFT}" y="20" font-weight="bold">{self.title}</text>']
        for x in self.x_ticks:
            parts.append(self.line((x, self.y_ticks[0]), (x, self.y_ticks[-1]), "#ddd"))
            at_x, at_y = self.place(x, self.y_ticks[0])
            parts.append(f'<text x="{at_x:.1f}" y="{at_y + 16:.1f}" text-anchor="middle">{number(x)}</text>')
        for y in self.y_ticks:
            parts.append(self.line((self.x_ticks[0], y), (self.x_ticks[-1], y), "#ddd"))
            at_x, at_y = self.place(self.x_ticks[0], y)
            parts.append(f'<text x="{at_x - 6:.1f}" y="{at_y + 4:.1f}" text-anchor="end">{number(y)}</text>')
        parts.append(f'<text x="{self.x0 + LEFT + (WIDTH - LEFT) / 2:.1f}" y="{HEIGHT - 8}" text-anchor="middle">'
                     f'{self.x_title}</text>')
        if self.limit:
            parts.append(self.line((self.x_ticks[0], self.limit), (self.x_ticks[-1], self.limit), "#888",
                                   'stroke-dasharray="5 4"'))
        for _, color, points in self.lines:
            parts += [self.line(a, b, color, 'stroke-width="2"') for a, b in zip(points, points[1:])]
            for x, y in (self.place(*point) for point in points):
                parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{color}"/>')
        return parts


def read_lines(files, value):
    rows = [row for file in files for row in json.loads(file.read_text())["rows"]]
    rows.sort(key=lambda row: row["points"])
    return [(name, color, [(row["points"] / 1e6, value(row[key], row)) for row in rows if key in row])
            for key, name, color in COMMANDS if any(key in row for row in rows)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("svg", type=pathlib.Path)
    parser.add_argument("scale", type=pathlib.Path, nargs="+")
    settings = parser.parse_args()
    microseconds = read_lines(settings.scale, lambda run, row: 1e6 * run["cpu_seconds"] / row["points"])
    megabytes = read_lines(settings.scale, lambda run, row: run["peak_mb"])
    panels = [Panel(0, "CPU time a point of the map, µs", "million points", microseconds),
              Panel(WIDTH, "memory of the process, MiB (dashed: 2 GiB)", "million points", megabytes, limit=2048)]
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * WIDTH + 90}" height="{HEIGHT}" '
             'font-family="sans-serif" font-size="12">', f'<rect width="{2 * WIDTH + 90}" height="{HEIGHT}" fill="white"/>']
    for panel in panels:
        parts += panel.draw()
    for k, (name, color, _) in enumerate(microseconds):
        y = TOP + 14 + 20 * k
        parts.append(f'<circle cx="{2 * WIDTH + 12}" cy="{y - 4}" r="4" fill="{color}"/>'
                     f'<text x="{2 * WIDTH + 22}" y="{y}">{name}</text>')
    settings.svg.write_text("\n".join(parts + ["</svg>"]) + "\n")


if __name__ == "__main__":
    main()
