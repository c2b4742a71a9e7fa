#include "edge_inputs.h"

#include "board_clock.h"

namespace tfsat {
namespace logger {

namespace {

// Above the sampling timer and USB, so that a stamp is not late by what they take.
constexpr uint8_t kEdgePriority = 64;

}  // namespace

EdgeInputs* EdgeInputs::active_ = nullptr;

void EdgeInputs::begin() {
  static_assert(protocol::kSwitchCount == 2, "one handler a switch");
  active_ = this;
  for (const uint8_t pin : pins_.switches) pinMode(pin, INPUT_PULLUP);
  pinMode(pins_.stroke, INPUT_PULLDOWN);
  attachInterrupt(pins_.switches[0], [] { active_->on_switch(0); }, CHANGE);
  attachInterrupt(pins_.switches[1], [] { active_->on_switch(1); }, CHANGE);
  attachInterrupt(pins_.stroke, [] { active_->on_stroke(); }, RISING);
  NVIC_SET_PRIORITY(IRQ_GPIO6789, kEdgePriority);
}

void EdgeInputs::on_switch(uint8_t index) {
  push(Edge{now_us(), Edge::Source::kSwitch, index, digitalRead(pins_.switches[index]) == HIGH, 0});
}

void EdgeInputs::on_stroke() { push(Edge{now_us(), Edge::Source::kStroke, 0, true, 0}); }

void EdgeInputs::push(Edge edge) {
  edge.lost = lost_;
  if (edges_.push(edge)) {
    lost_ = 0;
  } else if (lost_ < UINT16_MAX) {
    ++lost_;
  }
}

bool EdgeInputs::take_edge(Edge& edge) {
  const Edge* oldest = edges_.front();
  if (oldest == nullptr) return false;
  edge = *oldest;
  edges_.pop();
  return true;
}

uint8_t EdgeInputs::switches_open() {
  uint8_t open = 0;
  for (uint8_t i = 0; i < protocol::kSwitchCount; ++i) {
    if (digitalRead(pins_.switches[i]) == HIGH) open |= static_cast<uint8_t>(1u << i);
  }
  return open;
}

}  // namespace logger
}  // namespace tfsat
