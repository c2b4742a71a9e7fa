// Servo signals of joint 1, 2, 3 on D9, D10, D11 (OC1A, OC1B, OC1C).
//
// Timer 1 makes every edge by itself ("set" and "clear on compare match"), so an edge falls on its
// tick whatever the processor is doing. After each edge an interrupt prepares the next one, which
// is at least 0.5 ms away. Should interrupts ever be held off for longer than that, the edge is
// made as soon as they return: a pulse may then be late, but it is never left high for a turn of
// the timer.
//
// A stroke has begun when a whole pulse of its width was on the pin: low before, up at the rise, up
// until the fall, low again. The interrupts look at the pin at both edges; a pin change interrupt
// sees whatever moves it between them.
//
// D12 goes high for 1 ms when a pulse that may be the first of a stroke rises, some microseconds later,
// or up to 0.2 ms where another servo's edge came just before: the logger stamps it. Strokes that begin
// together share the mark.
#pragma once

#include "../core/ports.h"
#include "../core/pulse_train.h"

namespace tfsat {
namespace sequencer {

class Timer1Servos : public ServoOutput {
 public:
  explicit Timer1Servos(BegunChanges& begun) : changes_(begun) {}

  // Drives the lines low, then waits for hold(). Call after TickClock::begin().
  void begin();

  void hold(uint8_t joint, uint16_t width_ticks, uint32_t frame_ticks) override;
  void schedule(uint8_t joint, tick_t at, uint16_t width_ticks) override;
  bool cancel() override;
  void stop() override;
  uint16_t changes_begun() override;
  tick_t change_began_at(uint8_t index) override;

  // For the interrupts: the edge that was next on this channel has been made; the mark is over.
  void on_edge(uint8_t channel) { prepare_next_edge(channel); }
  void end_stroke_mark();

 private:
  static constexpr uint8_t kChannels = 3;
  // Less than this ahead, a compare match might be missed while it is being set up, which takes some
  // 130 cycles: 16 ticks.
  static constexpr int32_t kLeastLeadTicks = 24;

  enum class Edge : uint8_t { kNone, kRise, kFall };

  struct Channel {
    // In line it would be written out three times.
    __attribute__((noinline)) Channel(ChangeTable& changes, uint8_t joint)
        : train(changes, joint) {}

    PulseTrain train;
    Pulse pulse;
    Edge next = Edge::kNone;
  };

  void forget_changes();
  void prepare_next_edge(uint8_t channel);
  bool set_edge(uint8_t channel, tick_t at, bool high);
  void begin_stroke_mark();

  ChangeTable changes_;
  Channel channels_[kChannels] = {{changes_, 0}, {changes_, 1}, {changes_, 2}};
};

}  // namespace sequencer
}  // namespace tfsat
