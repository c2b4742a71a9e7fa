"""What to fly, and whether it may be flown.

design        the loop of strokes that turns a robot farthest in a given time: `problem`, `loops`, `swarm`,
              `optimum`; joints that move `together`, in the room that the tower leaves (`tower_room`)
sensitivity   how sure a rotation is: `parameters` and their errors, `study` (here or on a `cluster`)
orbit         `orbit`: primitives, chains of them planned and polished, a flight with feedback; loops on a `grid`
facility      a drop tower's file and release, the `reach_envelope` of a maneuver, and `tower_checks` of both

    found = design(load_robot(), DesignSettings(time_limit_s=1.5))
    found.optimum.alpha_deg, found.optimum.sequence, found.gap_deg

Angles in radians where the name does not say otherwise, quaternions (..., 4) with the scalar last, attitudes from body
axes to inertial axes.
"""
