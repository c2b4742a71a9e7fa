"""Settings to try: the board's limits, what is just beyond, and anything that fits the wire."""

from __future__ import annotations

from hypothesis import strategies as st

from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import ServoSettings

# Each limit of the protocol, one step to either side, and the ends of the wire's types.
EDGES_US = [0, 499, 500, 501, 1000, 1500, 2499, 2500, 2501, 65_535]
# 22,222: from 500 us on the steepest slope that stays within 2500 us over 90 deg; 22,223 does not.
EDGES_NS_PER_DEG = [0, 1999, 2000, 11_111, 22_222, 22_223, 30_000, 30_001, 65_535]
EDGES_CDEG = [-32_768, -1, 0, 1, 4500, 8999, 9000, 9001, 32_767]
EDGES_FRAME_US = [0, 4999, 5000, 10_000, 20_000, 20_001, 65_535]


@st.composite
def likely_settings(draw: st.DrawFn) -> ServoSetting:
    """Draw one joint's setting, often valid and often just at the end of the servo's range."""
    zero_us = draw(st.integers(500, 2500))
    ns_per_deg = draw(st.integers(2000, 30_000))
    reversed_ = draw(st.integers(0, 1))
    room_us = zero_us - 500 if reversed_ else 2500 - zero_us
    # Around the last angle whose pulse is still allowed: the board's rounding decides.
    end_cdeg = room_us * 100_000 // ns_per_deg + draw(st.integers(-1, 2))
    return ServoSetting(zero_us, ns_per_deg, reversed_, 0, draw(st.just(min(end_cdeg, 9000)) | st.just(9000)))


def any_setting() -> st.SearchStrategy[ServoSetting]:
    """Whatever fits the wire, mostly near a limit."""
    return st.builds(
        ServoSetting,
        st.sampled_from(EDGES_US) | st.integers(0, 65_535),
        st.sampled_from(EDGES_NS_PER_DEG) | st.integers(0, 65_535),
        st.sampled_from([0, 1]),
        st.just(0) | st.sampled_from(EDGES_CDEG),
        st.sampled_from(EDGES_CDEG) | st.integers(-32_768, 32_767),
    )


def all_settings() -> st.SearchStrategy[ServoSettings]:
    """Settings of three joints and the frame."""
    joint = likely_settings() | likely_settings() | any_setting()
    frame_us = st.just(20_000) | st.integers(5000, 20_000) | st.sampled_from(EDGES_FRAME_US)
    moving_at_once = st.integers(1, 3) | st.sampled_from([4, 255])
    return st.builds(ServoSettings, frame_us, st.tuples(joint, joint, joint), moving_at_once)


def valid_settings() -> st.SearchStrategy[ServoSettings]:
    """Settings that the board takes, by construction."""

    def joint(zero_us: int, ns_per_deg: int, reversed_: int, share: float) -> ServoSetting:
        # From the zero pulse to the end of the servo's range, in its direction.
        room_us = zero_us - 500 if reversed_ else 2500 - zero_us
        most_cdeg = min(9000, room_us * 100_000 // ns_per_deg)
        return ServoSetting(zero_us, ns_per_deg, reversed_, 0, max(1, round(share * most_cdeg)))

    joints = st.builds(
        joint, st.integers(600, 2400), st.integers(2000, 30_000), st.integers(0, 1), st.floats(0, 1)
    )
    return st.builds(ServoSettings, st.integers(5000, 20_000), st.tuples(joints, joints, joints))
