"""The messages of an evaluation that Foxglove has no schema for."""

from __future__ import annotations

from typing import Any

from tfsat_host.sdlog.export_mcap import Fields, classes_of

_TIMESTAMP = ".google.protobuf.Timestamp"
_VECTOR = ".foxglove.Vector3"

_MESSAGES: dict[str, Fields] = {
    "EulerAngles": (
        ("timestamp", _TIMESTAMP),
        ("z_deg", "double"),
        ("y_deg", "double"),
        ("x_deg", "double"),
        ("z_deg_std", "double"),
        ("y_deg_std", "double"),
        ("x_deg_std", "double"),
    ),
    "ModelAngles": (
        ("timestamp", _TIMESTAMP),
        ("z_deg", "double"),
        ("y_deg", "double"),
        ("x_deg", "double"),
    ),
    "BodyRate": (("timestamp", _TIMESTAMP), ("rate_deg_s", _VECTOR)),
    "EvaluatedJoint": (
        ("timestamp", _TIMESTAMP),
        ("angle_deg", "double"),
        ("angle_deg_std", "double"),
        ("rate_deg_s", "double"),
    ),
    "Momentum": (("timestamp", _TIMESTAMP), ("momentum_g_m2_s", _VECTOR)),
}
"""Fields are numbered in this order: append, never insert, so that older files keep their meaning."""


def message_classes() -> dict[str, Any]:
    """Name, such as `EulerAngles`, to class."""
    return classes_of("tfsat/evaluation.proto", _MESSAGES)
