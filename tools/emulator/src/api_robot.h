// What the C interface's handle points to.
#pragma once

#include <memory>
#include <string>

#include "api.h"
#include "robot.h"

struct TfsatRobot {
  TfsatRobot(const tfsat::emulator::RobotParameters& parameters,
             std::unique_ptr<tfsat::emulator::SequencerBoard> sequencer)
      : robot(parameters, std::move(sequencer)) {}
  tfsat::emulator::Robot robot;
  std::string crash;
};
