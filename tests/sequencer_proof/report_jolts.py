"""Section 1 of the report, continued: jolts, false releases, and the rule that three programs share."""

from __future__ import annotations

from tests.sequencer_proof.campaigns import Proof
from tests.sequencer_proof.jolts import MOST_JOLTS, Jolted
from tests.sequencer_proof.report_text import signed_range_us, table
from tests.sequencer_proof.signals import Extremes
from tfsat_host.protocol.limits import RELEASE_SEATED_US


def render(proof: Proof) -> str:
    return "\n\n".join([_jolted(proof), _closed_again(proof), _rule(proof)])


def _jolted(proof: Proof) -> str:
    jolted = [one for part in proof.jolted for one in part]
    kinds = [
        ("none", [one for one in jolted if not one.jolts]),
        (
            "1 or more, the edges fit one release",
            [one for one in jolted if one.jolts and not one.interval_us],
        ),
        ("1 or more, the edges fit two: an interval is told", [one for one in jolted if one.interval_us]),
    ]
    rows = [(name, len(kind), *_figures(kind)) for name, kind in kinds]
    return (
        "### Jolts before the release\n\n"
        f"Up to {MOST_JOLTS} jolts open one switch or both for 0.3 to 50 ms and let them close again, 0.3 to 40 ms "
        "apart, then the robot leaves; contacts\nbounce for up to 5 ms, all in the flashed image. The truth is the "
        "moment at which the robot left. Every interval that was told held it:\n\n"
        + table(
            (
                "jolts of both switches",
                "releases",
                "date off by, at most",
                "median",
                "widest interval",
            ),
            rows,
        )
    )


def _figures(kind: list[Jolted]) -> tuple[str, str, str]:
    errors = sorted(abs(one.error_us) for one in kind)
    if not errors:
        return "", "", ""
    widest = max(one.interval_us for one in kind)
    return (
        f"{errors[-1] / 1000:.3f} ms",
        f"{errors[len(errors) // 2] / 1000:.3f} ms",
        f"{widest / 1000:.1f} ms" if widest else "",
    )


def _closed_again(proof: Proof) -> str:
    flown = [release for part in proof.closed for release in part.releases]
    errors = signed_range_us(Extremes.of(error for release in flown for error in release.errors))
    rows = [
        (
            "before the first stroke",
            sum(part.before for part in proof.closed),
            "ARMED again, counted; nothing moved",
        ),
        ("the drops after these", len(flown), f"all four strokes, {errors} off"),
        (
            "after a stroke",
            sum(part.after for part in proof.closed),
            "FAULT `closed_while_running`; servos held, no stroke after it",
        ),
    ]
    return (
        "### Closed again\n\n"
        f"Both switches open as at a release and close again for good. After {RELEASE_SEATED_US // 1000} ms, in the "
        "flashed image:\n\n" + table(("closed", "runs", "outcome"), rows)
    )


def _rule(proof: Proof) -> str:
    trains, releases, ambiguous, false_releases = (
        sum(getattr(part, name) for part in proof.rule)
        for name in ("trains", "releases", "ambiguous", "false_releases")
    )
    return (
        "### One rule\n\n"
        f"Sequencer, logger and decoder were given the same {trains} random edge trains, most of their gaps within "
        f"2 µs of the rule's limits. They told\nthe same {releases} releases, {ambiguous} with an interval that holds "
        f"two, and {false_releases} of them false, to the microsecond."
    )
