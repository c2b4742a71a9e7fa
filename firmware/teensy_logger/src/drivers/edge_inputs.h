// Release switches and stroke line: each edge is stamped in its interrupt.
#pragma once

#include <Arduino.h>

#include "../core/ports.h"
#include "../core/spsc_queue.h"

namespace tfsat {
namespace logger {

// A closed switch pulls its pin low; the stroke line is high for 1 ms from each stroke's onset.
class EdgeInputs final : public Inputs {
 public:
  struct Pins {
    uint8_t switches[protocol::kSwitchCount];
    uint8_t stroke;
  };

  explicit EdgeInputs(const Pins& pins) : pins_(pins) {}

  // Only one object may begin: pin interrupts carry no argument.
  void begin();

  bool take_edge(Edge& edge) override;
  uint8_t switches_open() override;

 private:
  void on_switch(uint8_t index);
  void on_stroke();
  void push(Edge edge);

  static EdgeInputs* active_;
  Pins pins_;
  SpscQueue<Edge, 64> edges_;
  uint16_t lost_ = 0;
};

}  // namespace logger
}  // namespace tfsat
