"""What is wrong with what the sequencer has stored, from the bits of its status."""

from __future__ import annotations

from tfsat_host.protocol.enums import ErrorCode

STORES = {"maneuver": "the stored maneuver", "settings": "the servo settings"}
"""By the order of their bits."""
_WORDS = {
    ErrorCode.STORE_DAMAGED: ("is", "are", "damaged in the board's EEPROM"),
    ErrorCode.UPLOAD_INTERRUPTED: ("was", "were", "to be replaced by an upload that was never completed"),
    ErrorCode.STORE_OLD_LAYOUT: ("was", "were", "stored by an earlier firmware, in another layout"),
}


def store_defects(stores_damaged: int) -> dict[str, ErrorCode]:
    """For each store, by its name in STORES, why ARM is refused for it; NONE where nothing is against it."""
    found = dict.fromkeys(STORES, ErrorCode.NONE)
    for pair, code in enumerate(_WORDS):
        for index, store in enumerate(STORES):
            if stores_damaged >> (2 * pair + index) & 1:
                found[store] = code
    return found


def first_defect(stores_damaged: int) -> ErrorCode:
    """The reason that the board gives; NONE without one. It looks at the maneuver first."""
    return next((code for code in store_defects(stores_damaged).values() if code), ErrorCode.NONE)


def describe_defects(stores_damaged: int) -> str:
    """A sentence for each kind of defect."""
    defects = store_defects(stores_damaged)
    sentences = []
    for code in dict.fromkeys(code for code in defects.values() if code):
        names = [STORES[store] for store, found in defects.items() if found == code]
        singular, plural, what = _WORDS[code]
        verb = plural if names != [STORES["maneuver"]] else singular
        said = " and ".join(names)
        sentences.append(f"{said[:1].upper()}{said[1:]} {verb} {what}.")
    return " ".join(sentences)
