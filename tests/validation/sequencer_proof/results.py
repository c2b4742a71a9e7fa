"""The tables of docs/sequencer-proof.md. Every figure in them comes from a campaign or from the build."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from tests.validation.campaign import Campaign, Found, campaigns_csv, output
from tests.validation.sequencer_proof.bench import image_report
from tests.validation.sequencer_proof.blocking import (
    BLOCKED_BEFORE_RELEASE_MAX_US,
    BLOCKED_MAX_US,
    blocked_paths,
    path_rows,
)
from tests.validation.sequencer_proof.campaigns import DATES, least_never_used
from tests.validation.sequencer_proof.damage import TOLD, Damaged, Place
from tests.validation.sequencer_proof.half_transfers import disturbed_rows
from tests.validation.sequencer_proof.held_pins import HeldPins
from tests.validation.sequencer_proof.jog_lives import jog_row
from tests.validation.sequencer_proof.jolts import jolt_rows
from tests.validation.sequencer_proof.link import STATES, Abuse, Noise, Noisy
from tests.validation.sequencer_proof.one_closed import one_closed_rows
from tests.validation.sequencer_proof.power_cuts import Cuts, Record, Tear
from tests.validation.sequencer_proof.releases import (
    WORST_ERROR_US,
    all_releases,
    date_row,
    errors_us,
    signal_row,
    stroke_rows,
)
from tests.validation.sequencer_proof.signals import CYCLES_PER_US, Extremes
from tests.validation.tables import csv_text, results_csv
from tests.validation.targets import Target, targets_csv
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import FIRMWARE_VERSION, SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US

HANG_MAX_MS = 1300.0
CONTACTS = {"avr": "slow", "fast": "fast, and mixed with slow", "native": "mixed, native core"}


def make_tables(results: Found, campaigns: Sequence[Campaign], image: Path) -> dict[str, str]:
    """Return the text of each CSV file by its name. The same image and results give the same text."""
    noises = (
        "sent",
        "in all",
        *STATES,
        "damaged frames",
        "answers",
        "refusals",
        "ARM refused for its token",
        "drops",
    )
    tears = [f"byte {tear.value}" for tear in Tear]
    tables = {
        "campaigns": campaigns_csv(campaigns),
        "targets": targets_csv(find_targets(results, image)),
        "figures": csv_text(("of", "figure", "value"), list_figures(results)),
        "signals": csv_text(
            ("contacts chatter", "releases", "errors of the strokes, µs", "pulses, µs", "frames, ms"),
            [signal_row(words, results[name]) for name, words in CONTACTS.items()],
        ),
        "dates": csv_text(
            (
                "chatter",
                "releases",
                "within 1 µs",
                "1 to 50 µs",
                "more",
                "allowed",
                "worst, µs",
                "two answers",
            ),
            [date_row(chatter, results[name]) for chatter, (name, _, _) in DATES.items()],
        ),
        "strokes": results_csv(
            [row for name, words in CONTACTS.items() for row in stroke_rows(words, results[name])]
        ),
        "paths": results_csv(path_rows(image.with_suffix(".elf"))),
        "waits": results_csv(results["waits"]),
        "power-cuts": csv_text(
            ("upload of", "store held", "byte writes", "cut at", *tears, "stored when repeated"),
            [_cut_row(cuts) for cuts in results["cuts"]],
        ),
        "damage": csv_text(
            ("EEPROM with", "the byte is of", "tried", "armed unchanged", *TOLD),
            [_damage_row(damage, place) for damage in results["damaged"] for place in Place],
        ),
        "jolts": csv_text(
            (
                "jolts of both switches",
                "releases",
                "date off by at most ms",
                "median ms",
                "widest interval ms",
            ),
            jolt_rows(results["jolted"]),
        ),
        "half-transfers": csv_text(
            (
                "control transfers of the host",
                "second switch within",
                "releases",
                "within 50 µs",
                "more",
                "worst, ms",
                "with an interval",
                "truth outside",
            ),
            disturbed_rows(results["disturbed"]),
        ),
        "one-closed": csv_text(
            (
                "one switch closed again for",
                "releases",
                "date late by at most, ms",
                "with an interval",
                "truth outside",
            ),
            one_closed_rows(results["one_closed"]),
        ),
        "link": csv_text(
            ("host", "runs", "a stroke moved in"),
            [(abuse, *(sum(row) for row in zip(*_runs(abuse, results), strict=True))) for abuse in Abuse],
        ),
        "noise": csv_text(noises, [_noise_row(noise, results["noisy"]) for noise in Noise]),
        "resets": results_csv(results["resets"]),
        "hangs": results_csv(results["hangs"]),
        "held-pins": results_csv(results["held"]),
        "jog": csv_text(
            (
                "lives",
                "orders",
                "DISARMs, closed ports, pulled cables, resets",
                "times a joint was driven",
                "pulses",
            ),
            [jog_row(results["jogs"])],
        ),
    }
    return {f"{name}.csv": text for name, text in tables.items()}


def describe_image(image: Path) -> dict[str, object]:
    """Return what the campaigns were run with besides the HEX."""
    return {
        "firmware": ".".join(map(str, FIRMWARE_VERSION)),
        "CRC-32 of the image, in HELLO and STATUS": image_report(image)["image_crc32"],
        "compiler": f"avr-gcc {output('avr-gcc', '-dumpversion')}",
        "emulator": f"libsimavr {output('pkg-config', '--modversion', 'simavr')}",
    }


def find_targets(results: Found, image: Path) -> list[Target]:
    """Return what the image is held to, with its bounds."""
    report, elf = image_report(image), image.with_suffix(".elf")
    slow = all_releases(results["avr"])
    errors, widths = (
        errors_us(slow),
        Extremes.of((us for release in slow for us in release.widths), CYCLES_PER_US),
    )
    return [
        Target("earliest stroke, slow chatter", errors.least, low=-WORST_ERROR_US, unit="µs"),
        Target("latest stroke, slow chatter", errors.greatest, high=WORST_ERROR_US, unit="µs"),
        Target("shortest pulse", widths.least, SERVO_PULSE_MIN_US, SERVO_PULSE_MAX_US, "µs"),
        Target("longest pulse", widths.greatest, SERVO_PULSE_MIN_US, SERVO_PULSE_MAX_US, "µs"),
        Target(
            "reset by the watchdog, at the latest", _hang_ms(results).greatest, high=HANG_MAX_MS, unit="ms"
        ),
        Target("interrupts off, strokes ahead", _blocked_us(elf), high=BLOCKED_MAX_US, unit="µs"),
        Target(
            "interrupts off, before the release",
            _blocked_us(elf, scheduled=False),
            high=BLOCKED_BEFORE_RELEASE_MAX_US,
            unit="µs",
        ),
        Target("flash", int(report["flash_bytes"]), high=int(report["flash_budget_bytes"]), unit="bytes"),
        Target("static RAM", int(report["ram_bytes"]), high=int(report["ram_budget_bytes"]), unit="bytes"),
        Target(
            "stack never touched", least_never_used(results), int(report["stack_spare_bytes"]), unit="bytes"
        ),
    ]


def _blocked_us(elf: Path, scheduled: bool = True) -> float:
    return blocked_paths(elf, scheduled=scheduled)[0].cycles / CYCLES_PER_US


def _hang_ms(results: Found) -> Extremes:
    return Extremes.of(ms for hangs in results["hangs"] for ms in hangs.reset_after_ms)


def list_figures(results: Found) -> list[tuple[str, str, object]]:
    """Return what the page's sections rest on: section, figure, value."""
    damaged, resets = results["damaged"], results["resets"]
    after = Extremes.of(us for reset in resets if reset.errors_us for us in reset.errors_us)
    closed, rule = results["closed"], results["rule"]
    figures: dict[str, dict[str, object]] = {
        "releases": {
            "edges of a release, at most": max(
                release.contact_edges for name in CONTACTS for release in all_releases(results[name])
            ),
            "false triggers of one switch": sum(part.one_switch for part in results["knocks"]),
            "false triggers of both": sum(part.both_switches for part in results["knocks"]),
            "closed again before the first stroke": sum(part.before for part in closed),
            "drops after that, µs off": errors_us([release for part in closed for release in part.releases]),
            "closed again after a stroke": sum(part.after for part in closed),
            "random edge trains": sum(part.trains for part in rule),
            "releases in them, found alike": sum(part.releases for part in rule),
            "with an interval that holds two": sum(part.ambiguous for part in rule),
            "false ones": sum(part.false_releases for part in rule),
            "jolts whose edges fit one release, ms off at most": max(
                float(str(row[2])) for row in jolt_rows(results["jolted"])[:2]
            ),
        },
        "power cuts": {
            "cut points": sum(cuts.points for cuts in results["cuts"]),
            **{
                f"byte writes of an upload of the {record.value} that is stored": n
                for record, n in zip(Record, results["rewrites"], strict=True)
            },
            "damaged bytes tried": sum(damage.values.total() for damage in damaged),
            "armed unchanged": sum(damage.armed.total() for damage in damaged),
            "tried in the image": sum(damage.tried for damage in results["damaged_image"]),
        },
        "link": {
            "runs": sum(result.runs for result in results["abused"]),
            "a stroke moved in": sum(result.moved for result in results["abused"]),
            "random bytes": _noise_row(Noise.BYTES, results["noisy"])[1],
            "random frames": _noise_row(Noise.FRAMES, results["noisy"])[1],
        },
        "resets": {
            "resets": sum(reset.resets for reset in resets),
            "first pulse after, ms at most": f"{max(reset.silence_ms.greatest for reset in resets):.2f}",
            "strokes of a release after it, µs off": after,
            "hangs": sum(hangs.hangs for hangs in results["hangs"]),
            "reset after, ms": _hang_ms(results),
        },
        "pins held": _held_figures(results["held"]),
        "together": _together_figures(results),
    }
    return [(section, what, value) for section, rows in figures.items() for what, value in rows.items()]


def _held_figures(held: Sequence[HeldPins]) -> dict[str, object]:
    return {
        "runs": sum(result.runs for result in held),
        "strokes on time": sum(result.on_time for result in held),
        "late": sum(result.late for result in held),
        "missed": sum(result.missed for result in held),
    }


def _together_figures(results: Found) -> dict[str, object]:
    """Return the figures of strokes of joints that move together."""
    releases = all_releases(results["together"])
    resets, held = results["together_resets"], _held_figures(results["together_held"])
    strokes = results["together"][0].plan.strokes
    # Of each pair that begins together the difference of the two errors.
    pairs = [(i, i + 1) for i, (one, other) in enumerate(pairwise(strokes)) if one[2] == other[2]]
    apart = [abs(release.errors[i] - release.errors[k]) for release in releases for i, k in pairs]
    return {
        "releases": len(releases),
        "errors of the strokes, µs": errors_us(releases),
        "strokes that begin together, µs apart at most": max(apart) / CYCLES_PER_US,
        "closed again before the first stroke, and after it": sum(
            part.before + part.after for part in results["together_closed"]
        ),
        "runs with an abused link": sum(result.runs for result in results["together_abused"]),
        "a stroke moved in": sum(result.moved for result in results["together_abused"]),
        "resets": sum(reset.resets for reset in resets),
        **{f"pins held: {figure}": value for figure, value in held.items()},
    }


def _cut_row(cuts: Cuts) -> tuple[object, ...]:
    outcomes = (f"{cuts.old[tear]} / {cuts.told[tear]} / {cuts.new[tear]}" for tear in Tear)
    return cuts.record, cuts.history, cuts.writes, cuts.points, *outcomes, cuts.stored_afterwards


def _damage_row(damage: Damaged, place: Place) -> tuple[object, ...]:
    return (
        damage.case,
        place,
        damage.values[place],
        damage.armed[place],
        *(damage.refused[place, code] for code in TOLD),
    )


def _runs(abuse: Abuse, results: Found) -> list[tuple[int, int]]:
    return [(part.runs, part.moved) for part in results["abused"] if part.abuse is abuse]


def _noise_row(noise: Noise, noisy_runs: Sequence[Noisy]) -> tuple[object, ...]:
    parts = [part for part in noisy_runs if part.noise is noise]
    sent = [sum(part.sent[state] for part in parts) for state in STATES]
    counts = (sum(getattr(part, name) for part in parts) for name in ("rejected", "answers", "refusals"))
    tokens = sum(part.arms_refused[ErrorCode.STALE_TOKEN] for part in parts)
    return noise, sum(sent), *sent, *counts, tokens, sum(part.drops for part in parts)
