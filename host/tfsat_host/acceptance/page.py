"""The page of an acceptance: one HTML file that needs nothing but itself, for whoever was not at the bench."""

from __future__ import annotations

import html
from collections.abc import Sequence

from tfsat_host.acceptance.record import Acceptance, AcceptedBoard, StepResult
from tfsat_host.acceptance.steps import STEPS
from tfsat_host.preflight.preflight_check import GoNoGo, PreflightCheck

_WORDS = {GoNoGo.GO: "ok", GoNoGo.NO_GO: "wrong", GoNoGo.NOT_MADE: "not made"}
_STYLE = """
:root { color-scheme: light dark; --ok: #1b7f4b; --bad: #b3261e; --line: #8886; }
body { font: 16px/1.45 system-ui, sans-serif; max-width: 60rem; margin: 0 auto; padding: 1rem;
  overflow-wrap: anywhere; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.05rem; margin: 1.4rem 0 .3rem; }
.verdict { font-weight: 700; padding: .6rem .8rem; border-left: .4rem solid; }
.ok { color: var(--ok); } .bad { color: var(--bad); }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1rem; margin: 0; } dd { margin: 0; }
table { border-collapse: collapse; width: 100%; }
td { border-top: 1px solid var(--line); padding: .35rem .5rem .35rem 0; vertical-align: top; }
td:first-child { width: 5.5rem; font-weight: 600; white-space: nowrap; } .next { display: block; opacity: .8; }
svg { width: 100%; max-width: 32rem; height: auto; } svg text { font-size: 11px; fill: currentColor; }
"""
_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>tfsat acceptance</title><style>{style}</style></head>
<body><h1>Acceptance{emulated}</h1>
<p class="verdict {verdict_class}">{verdict}</p>
<dl>{facts}</dl>
{steps}
</body></html>
"""
_TITLES = {step.name: step.title for step in STEPS}
_WIDTH, _HEIGHT, _EDGE = 400, 130, 48


def render_page(acceptance: Acceptance) -> str:
    """Render the page, to be written as UTF-8."""
    facts = [
        *(
            [("Date", f"{max(step.at for step in acceptance.steps):%Y-%m-%d %H:%M} UTC")]
            if acceptance.steps
            else []
        ),
        ("Sequencer", _describe(acceptance.sequencer)),
        ("Logger", _describe(acceptance.logger)),
    ]
    return _PAGE.format(
        style=_STYLE,
        emulated=" (emulated robot)" if acceptance.emulated else "",
        verdict_class="bad" if acceptance.remaining else "ok",
        verdict=html.escape(acceptance.verdict_line),
        facts="".join(f"<dt>{name}</dt><dd>{html.escape(text)}</dd>" for name, text in facts),
        steps="\n".join(map(_render_step, acceptance.steps)),
    )


def _describe(board: AcceptedBoard) -> str:
    image = f"image {board.image_crc}" if int(board.image_crc, 16) else "run natively, no image"
    return f"serial number {board.serial or 'none'}, firmware {board.firmware}, {image}"


def _render_step(step: StepResult) -> str:
    rows = "".join(map(_render_check, step.checks))
    pictures = "".join(_draw_residuals(check) for check in step.checks if check.name == "stroke-times")
    return f"<h2>{html.escape(_TITLES.get(step.name, step.name))}</h2><table>{rows}</table>{pictures}"


def _render_check(check: PreflightCheck) -> str:
    following = f'<span class="next">Next: {html.escape(check.next_step)}</span>' if check.blocks else ""
    kind = "bad" if check.blocks else "ok"
    return f'<tr><td class="{kind}">{_WORDS[check.verdict]}</td><td>{html.escape(check.sentence)}{following}</td></tr>'


def _draw_residuals(check: PreflightCheck) -> str:
    """Draw each stroke's residual against the time at which it was scheduled."""
    times_s: Sequence[float] = check.evidence.get("scheduled_s", ())
    residuals_us: Sequence[float] = check.evidence.get("residual_us", ())
    if not times_s:
        return ""
    full_us = max(10.0, 1.2 * max(map(abs, residuals_us)))
    middle, until_s = _HEIGHT / 2, 1.1 * max(times_s)
    marks = []
    for t_s, residual_us in zip(times_s, residuals_us, strict=True):
        x = _EDGE + (_WIDTH - 2 * _EDGE) * t_s / until_s
        y = middle - (middle - 24) * residual_us / full_us
        marks.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{middle}" y2="{y:.1f}" stroke="currentColor"/>'
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="currentColor"/>'
            f'<text x="{x:.1f}" y="{_HEIGHT - 4}" text-anchor="middle">{t_s:.2f}</text>'
        )
    scale = "".join(
        f'<text x="4" y="{middle - sign * (middle - 24) + 4:.0f}">{sign * full_us:+.0f} µs</text>'
        for sign in (1, -1)
    )
    axis = f'<line x1="{_EDGE}" x2="{_WIDTH - _EDGE}" y1="{middle}" y2="{middle}" stroke="currentColor" opacity=".5"/>'
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="Residual of each stroke by its scheduled time">'
        f"{axis}{''.join(marks)}{scale}"
        f'<text x="{_WIDTH - 4}" y="{_HEIGHT - 4}" text-anchor="end">s</text></svg>'
    )
