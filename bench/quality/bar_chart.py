"""Grouped bars with quartile whiskers, as an SVG file."""

import math
from dataclasses import dataclass

LABEL_PX = 11
BAR_PX = 15
GROUP_GAP_PX = 26
PLOT_HEIGHT_PX = 220
LEFT_PX, TOP_PX, BOTTOM_PX = 48, 84, 34
MIN_WIDTH_PX = 520  # two lines of a legend of nine series


@dataclass(frozen=True)
class Bar:
    series: str
    middle: float
    low: float
    high: float


def text(x, y, content, anchor="middle", size=LABEL_PX, fill="#333"):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" fill="{fill}">{content}</text>'


def tick_step(top):
    """1, 2 or 5 times a power of ten, so that there are four to ten ticks up to `top`."""
    power = 10.0 ** math.floor(math.log10(top / 4.0))
    return next(power * factor for factor in (5, 2, 1) if power * factor <= top / 4.0)


class Scale:
    """Pixel row of a value."""

    def __init__(self, top_value):
        self.top_value = top_value

    def __call__(self, value):
        return TOP_PX + PLOT_HEIGHT_PX * (1.0 - value / self.top_value)


def bar_elements(bar, x, y_of, color):
    """The bar, the whisker from quartile to quartile, and the bar's value above both."""
    middle = x + 0.5 * BAR_PX - 1
    top = y_of(bar.middle)
    return [f'<rect x="{x:.1f}" y="{top:.1f}" width="{BAR_PX - 2}" height="{y_of(0.0) - top:.1f}" fill="{color}"/>',
            f'<path d="M{middle:.1f} {y_of(bar.low):.1f}V{y_of(bar.high):.1f}" stroke="#222" fill="none"/>',
            text(middle, y_of(max(bar.middle, bar.high)) - 3, f"{bar.middle:.2g}", size=8)]


def legend(colors, width):
    elements, x, y = [], LEFT_PX, 32
    for series, color in colors.items():
        needed = 22 + 6.2 * len(series)
        if x + needed > width and x > LEFT_PX:
            x, y = LEFT_PX, y + 14
        elements.append(f'<rect x="{x:.1f}" y="{y - 9}" width="10" height="10" fill="{color}"/>')
        elements.append(text(x + 14, y, series, anchor="start", size=10))
        x += needed
    return elements


def svg(title, unit, groups, colors):
    """`groups`: name -> bars (at least one in all), drawn in the order given; `colors`: series -> colour, also the
    legend's order."""
    top_value = max(max(bar.middle, bar.high) for group in groups.values() for bar in group)
    bars = sum(len(group) for group in groups.values())
    width = max(MIN_WIDTH_PX, LEFT_PX + bars * BAR_PX + (len(groups) + 1) * GROUP_GAP_PX)
    height = TOP_PX + PLOT_HEIGHT_PX + BOTTOM_PX
    y_of = Scale(top_value)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif">',
             f'<rect width="{width}" height="{height}" fill="#fff"/>', text(LEFT_PX, 16, title, "start", 13),
             *legend(colors, width)]
    step = tick_step(top_value)
    for i in range(int(top_value / step) + 1):
        parts.append(f'<path d="M{LEFT_PX} {y_of(i * step):.1f}H{width - 8}" stroke="#ddd" fill="none"/>')
        parts.append(text(LEFT_PX - 5, y_of(i * step) + 4, f"{i * step:g}", "end"))
    parts.append(text(14, TOP_PX - 14, unit, "start"))
    x = LEFT_PX + GROUP_GAP_PX
    for name, group in groups.items():
        parts.append(text(x + 0.5 * BAR_PX * len(group), height - 12, name, size=12))
        for bar in group:
            parts += bar_elements(bar, x, y_of, colors[bar.series])
            x += BAR_PX
        x += GROUP_GAP_PX
    return "\n".join(parts + ["</svg>"]) + "\n"
