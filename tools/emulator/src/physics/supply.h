// The supply of servos and sequencer: a battery behind a resistance, loaded by the servos (docs/wiring.md, supplies).
#pragma once

namespace tfsat {
namespace emulator {

// Battery current of one servo through its converter. Assumed for a standard servo on 6 V: measure yours.
constexpr double kServoStart_A = 1.0;    // while it speeds up
constexpr double kServoRunning_A = 0.6;  // moves on, or brakes
constexpr double kServoHolding_A = 0.01;
constexpr double kServoMoving_rad_s = 0.2;  // slower than that it only corrects where it holds

constexpr double kBattery_V = 7.4;              // two cells of Li-ion, half full
constexpr double kBatteryResistance_ohm = 0.1;  // with fuse, switch and plugs; assumed
constexpr double kDiode_V = 0.45;               // CR3, 1N5817 at 1 A (data sheet)
constexpr double kDropout_V = 1.2;              // of the Micro's regulator (docs/wiring.md)
constexpr double kBrownOut_V = 4.3;             // ATmega32U4 datasheet 7766J, table 8-1, BODLEVEL 0

class Supply {
 public:
  void set_resistance(double resistance_ohm) { resistance_ohm_ = resistance_ohm; }
  // Whether the sequencer's 5 V, without its regulator's limit above, are below its brown-out threshold.
  bool low(double current_A) const {
    return kBattery_V - resistance_ohm_ * current_A - kDiode_V - kDropout_V < kBrownOut_V;
  }

 private:
  double resistance_ohm_ = kBatteryResistance_ohm;
};

}  // namespace emulator
}  // namespace tfsat
