"""The design of a maneuver under its documented name: see `tfsat_host.plan.design`."""

from tfsat_host.plan.design import Candidate as Candidate
from tfsat_host.plan.design import Design as Design
from tfsat_host.plan.design import design as design
from tfsat_host.plan.problem import DesignSettings as DesignSettings
