"""The look of every figure: the page's colours, a light and a dark template."""

from typing import Any

# the same as in app/web/shared/palette.js, which a test compares
DOMAINS = ["#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#f0e442", "#8c8c8c"]
CLASSES = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#aa3377", "#66ccee", "#bbbbbb", "#332288"]
MODALITIES = ["#56b4e9", "#e69f00"]
RIGHT_WRONG = ["#009e73", "#d55e00"]
READINGS = {"fused": "#8b5cf6", "vis": MODALITIES[0], "tac": MODALITIES[1]}
# at least 3:1 on the white and on the dark page
ACCENT, SOFT, MARK, AREA = "#3b82f6", "#7a8699", "#dc2626", "rgba(59,130,246,0.2)"
SERIES = [ACCENT, "#d55e00", "#009e73", "#8b5cf6", "#c2569a", SOFT]
FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif'
THEMES = {  # the variables of app/web/shared/page.css
    "omnivat": {"ink": "#0f172a", "line": "#dbe2ea", "card": "#ffffff", "full": "#1d4ed8"},
    "omnivat_dark": {"ink": "#e8eef6", "line": "#2b3a52", "card": "#0f172a", "full": "#7db4ff"},
}
MARGIN = {"l": 70, "r": 24, "t": 48, "b": 56}
# plotly.js 4 shows a button that uploads the figure, and a logo that links to its maker
CONFIG: dict[str, Any] = {
    "displaylogo": False,
    "showSendToCloud": False,
    "plotlyServerURL": "",
    "topojsonURL": "data:,",
    "responsive": True,
}
UPLOAD = "sendChartToCloud"


def template(name: str) -> dict[str, Any]:
    """Return the template of a theme: "omnivat" or "omnivat_dark"."""
    colour = THEMES[name]
    ink, line, card = colour["ink"], colour["line"], colour["card"]
    axis = {"gridcolor": line, "linecolor": line, "zerolinecolor": line, "automargin": True}
    legend = {
        "orientation": "h",
        "yref": "container",
        "yanchor": "bottom",
        "itemsizing": "constant",
    }
    return {
        "layout": {
            "font": {"family": FONT, "color": ink, "size": 13},
            "title": {"x": 0, "xref": "container", "pad": {"l": 12}, "font": {"size": 16}},
            "paper_bgcolor": card,
            "plot_bgcolor": card,
            "colorway": SERIES,
            "margin": MARGIN,
            "hoverlabel": {"bgcolor": card, "bordercolor": line, "font": {"color": ink}},
            "legend": {**legend, "x": 0, "y": 0},
            "modebar": {"remove": [UPLOAD], "bgcolor": card, "color": SOFT, "activecolor": ACCENT},
            "xaxis": axis,
            "yaxis": axis,
            "scene": {f"{k}axis": {"backgroundcolor": card, "gridcolor": line} for k in "xyz"},
        },
        "data": {
            "heatmap": [
                {
                    "colorscale": [card, colour["full"]],
                    "colorbar": {"outlinewidth": 0, "thickness": 12},
                }
            ]
        },
    }
