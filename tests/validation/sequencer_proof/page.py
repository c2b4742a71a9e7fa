"""docs/sequencer-proof.md and its tables. Every figure in them comes from a campaign or from the build."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from tests.validation.campaign import Campaign, Found, csv_text, declared, output, results_csv, table
from tests.validation.sequencer_proof.blocking import blocked_paths, path_rows
from tests.validation.sequencer_proof.campaigns import DATES, least_never_used
from tests.validation.sequencer_proof.damage import TOLD, Damaged, Place
from tests.validation.sequencer_proof.jolts import TOLERANCE_US, jolt_rows
from tests.validation.sequencer_proof.link import STATES, Abuse, Noise, Noisy
from tests.validation.sequencer_proof.power_cuts import Cuts, Record, Tear
from tests.validation.sequencer_proof.releases import (
    all_releases,
    date_row,
    errors_us,
    signal_row,
    stroke_rows,
)
from tests.validation.sequencer_proof.rigs import image_report
from tests.validation.sequencer_proof.signals import CYCLES_PER_US, Extremes
from tfsat_host.flashing.image import FLASH_BYTES
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import FIRMWARE_VERSION

RAM_BYTES = 2560
CONTACTS = {"avr": "slow", "fast": "fast, and mixed with slow", "native": "mixed, native core"}


def hex_sha256(image: Path) -> str:
    """Of the HEX file as it is handed to avrdude."""
    return hashlib.sha256(image.read_bytes()).hexdigest()


def files(found: Found, campaigns: Sequence[Campaign], image: Path) -> dict[str, str]:
    """The page and its tables, by their paths in docs/. The same image and results give the same text."""
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
        "campaigns": declared(campaigns),
        "strokes": results_csv(
            [row for name, words in CONTACTS.items() for row in stroke_rows(words, found[name])]
        ),
        "paths": results_csv(path_rows(image.with_suffix(".elf"))),
        "waits": results_csv(found["waits"]),
        "power-cuts": csv_text(
            ("upload of", "store held", "byte writes", "cut at", *tears, "stored when repeated"),
            [_cut_row(cuts) for cuts in found["cuts"]],
        ),
        "damage": csv_text(
            ("EEPROM with", "the byte is of", "tried", "armed unchanged", *TOLD),
            [_damage_row(one, place) for one in found["damaged"] for place in Place],
        ),
        "jolts": csv_text(
            (
                "jolts of both switches",
                "releases",
                "date off by at most ms",
                "median ms",
                "widest interval ms",
            ),
            jolt_rows(found["jolted"]),
        ),
        "link": csv_text(
            ("host", "runs", "a stroke moved in"),
            [(abuse, *(sum(row) for row in zip(*_runs(abuse, found), strict=True))) for abuse in Abuse],
        ),
        "noise": csv_text(noises, [_noise_row(noise, found["noisy"]) for noise in Noise]),
        "resets": results_csv(found["resets"]),
        "hangs": results_csv(found["hangs"]),
        "held-pins": results_csv(found["held"]),
    }
    page = (Path(__file__).with_name("page.in.md")).read_text(encoding="utf-8")
    return {
        "sequencer-proof.md": page.format(**_head(image), **_figures(found), **_size(found, image)),
        **{f"sequencer-proof/{name}.csv": text for name, text in tables.items()},
    }


def _head(image: Path) -> dict[str, object]:
    return {
        "version": ".".join(map(str, FIRMWARE_VERSION)),
        "sha256": hex_sha256(image),
        "crc32": image_report(image)["image_crc32"],
        "gcc": output("avr-gcc", "-dumpversion"),
        "simavr": output("pkg-config", "--modversion", "simavr"),
    }


def _figures(found: Found) -> dict[str, object]:
    cuts, damaged, held, resets = (found[name] for name in ("cuts", "damaged", "held", "resets"))
    after = Extremes.of(us for one in resets if one.errors_us for us in one.errors_us)
    return {
        "signals": table(
            ("contacts chatter", "releases", "errors of the strokes, µs", "pulses, µs", "frames, ms"),
            [signal_row(words, found[name]) for name, words in CONTACTS.items()],
        ),
        "most_edges": max(one.contact_edges for name in CONTACTS for one in all_releases(found[name])),
        "dates": table(
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
            [date_row(chatter, found[name]) for chatter, (name, _, _) in DATES.items()],
        ),
        "jolt_tolerance_ms": TOLERANCE_US / 1000,
        "jolt_worst_ms": max(float(str(row[2])) for row in jolt_rows(found["jolted"])[:2]),
        "knocks_one": sum(part.one_switch for part in found["knocks"]),
        "knocks_both": sum(part.both_switches for part in found["knocks"]),
        "closed": sum(part.before for part in found["closed"]),
        "caught": sum(part.after for part in found["closed"]),
        "closed_errors": errors_us([one for part in found["closed"] for one in part.releases]),
        "trains": sum(part.trains for part in found["rule"]),
        "rule_releases": sum(part.releases for part in found["rule"]),
        "ambiguous": sum(part.ambiguous for part in found["rule"]),
        "false_releases": sum(part.false_releases for part in found["rule"]),
        "cut_points": sum(one.points for one in cuts),
        "rewrites": ", ".join(
            f"{record.value} {n}" for record, n in zip(Record, found["rewrites"], strict=True)
        ),
        "bytes_tried": sum(one.values.total() for one in damaged),
        "bytes_armed": sum(one.armed.total() for one in damaged),
        "bytes_in_image": sum(one.tried for one in found["damaged_image"]),
        "abused": sum(one.runs for one in found["abused"]),
        "moved": sum(one.moved for one in found["abused"]),
        "random_bytes": _noise_row(Noise.BYTES, found["noisy"])[1],
        "random_frames": _noise_row(Noise.FRAMES, found["noisy"])[1],
        "resets": sum(one.resets for one in resets),
        "silence": f"{max(one.silence_ms.greatest for one in resets):.2f}",
        "after_reset": after,
        "hangs": sum(one.hangs for one in found["hangs"]),
        "hang_ms": Extremes.of(ms for one in found["hangs"] for ms in one.reset_after_ms),
        **{name: sum(getattr(one, name) for one in held) for name in ("runs", "on_time", "late", "missed")},
    }


def _size(found: Found, image: Path) -> dict[str, object]:
    report, elf = image_report(image), image.with_suffix(".elf")
    flash_budget, ram_budget = report["flash_budget_bytes"], report["ram_budget_bytes"]
    flash = f"{report['flash_bytes']} ({report['flash_percent']}%)"
    rows = [
        ("flash", flash, f"at most {flash_budget} of {FLASH_BYTES} after the bootloader"),
        ("static RAM", report["ram_bytes"], f"at most {ram_budget} of {RAM_BYTES}"),
        ("stack never touched", least_never_used(found), f"at least {report['stack_spare_bytes']}"),
    ]
    return {
        "size": table(("", "bytes", "budget"), rows),
        "blocked_before_us": f"{blocked_paths(elf, scheduled=False)[0].cycles / CYCLES_PER_US:.1f}",
        "blocked_us": f"{blocked_paths(elf)[0].cycles / CYCLES_PER_US:.1f}",
    }


def _cut_row(cuts: Cuts) -> tuple[object, ...]:
    outcomes = (f"{cuts.old[tear]} / {cuts.told[tear]} / {cuts.new[tear]}" for tear in Tear)
    return cuts.record, cuts.history, cuts.writes, cuts.points, *outcomes, cuts.stored_afterwards


def _damage_row(one: Damaged, place: Place) -> tuple[object, ...]:
    return one.case, place, one.values[place], one.armed[place], *(one.refused[place, code] for code in TOLD)


def _runs(abuse: Abuse, found: Found) -> list[tuple[int, int]]:
    return [(part.runs, part.moved) for part in found["abused"] if part.abuse is abuse]


def _noise_row(noise: Noise, found: Sequence[Noisy]) -> tuple[object, ...]:
    parts = [part for part in found if part.noise is noise]
    sent = [sum(part.sent[state] for part in parts) for state in STATES]
    counts = (sum(getattr(part, name) for part in parts) for name in ("rejected", "answers", "refusals"))
    tokens = sum(part.arms_refused[ErrorCode.STALE_TOKEN] for part in parts)
    return noise, sum(sent), *sent, *counts, tokens, sum(part.drops for part in parts)
