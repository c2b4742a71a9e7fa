#include "logger_board.h"

#include <algorithm>

#include "logger_bus_port.h"
#include "logger_card_port.h"
#include "logger_ports.h"

namespace tfsat {
namespace emulator {

// What is gone when the power goes.
class LoggerBoard::Firmware {
 public:
  Firmware(LoggerBoard& board, uint64_t seed)
      : bus_a((*board.buses_)[0], interrupt_clock),
        bus_b((*board.buses_)[1], interrupt_clock),
        adc(*board.angle_sensors_, board.joints_, board.angle_wires_),
        card(*board.card_),
        memory(board.memory_),
        entropy(seed),
        core(logger::Ports{bus_a, bus_b, adc, inputs, timer, card, card, memory, stream, entropy},
             board.parameters_.identity, board.ring_.data(),
             static_cast<uint32_t>(board.ring_.size())) {}

  InterruptClock interrupt_clock;
  BusPort bus_a;
  BusPort bus_b;
  AdcPort adc;
  InputsPort inputs;
  TimerPort timer;
  CardPort card;
  MemoryPort memory;
  StreamPort stream;
  SeededEntropy entropy;
  logger::Logger core;
};

LoggerBoard::LoggerBoard(uint64_t seed, const LoggerBoardParameters& parameters)
    : seed_(seed),
      parameters_(parameters),
      ring_(logger::kRingBlocks),
      memory_(kMemoryBytes, 0xFF) {}

LoggerBoard::~LoggerBoard() = default;

void LoggerBoard::attach(std::array<I2cBus, 2>& buses, std::vector<AngleSensor>& angle_sensors,
                         BlockDevice& card) {
  buses_ = &buses;
  angle_sensors_ = &angle_sensors;
  card_ = &card;
}

void LoggerBoard::set_joint(int sensor, double angle_rad, double rate_rad_s) {
  joints_.at(static_cast<size_t>(sensor)) = {angle_rad, rate_rad_s};
}

void LoggerBoard::set_power(bool on) {
  if (on == (firmware_ != nullptr) || card_ == nullptr) return;
  if (!on) {
    firmware_.reset();
    return;
  }
  powered_us_ = now_us_;
  next_loop_us_ = now_us_;
  work_until_us_ = now_us_;
  const uint64_t seed = seed_ + (boots_++ << 32);  // other session ids after each start
  firmware_ = std::make_unique<Firmware>(*this, seed);
  firmware_->card.set_powered_at(powered_us_);
  firmware_->stream.set_connected(cable_);
  for (int i = 0; i < 2; ++i) firmware_->inputs.preset(i, !switch_closed_[i]);
  firmware_->core.begin();
}

uint64_t LoggerBoard::next_sample_us() const {
  if (firmware_ == nullptr) return UINT64_MAX;
  const uint64_t next_us = firmware_->timer.next_us();
  return next_us == UINT64_MAX ? next_us : powered_us_ + next_us;
}

void LoggerBoard::advance_to(uint64_t t_us) {
  while (firmware_ != nullptr) {
    const uint64_t next_us = std::min(next_sample_us(), next_loop_us_);
    if (next_us > t_us) break;
    if (next_us == next_sample_us()) {
      sample(next_us);
    } else {
      firmware_->timer.set_now(board_us(next_us));
      firmware_->card.set_now(board_us(next_us));
      firmware_->core.poll(board_us(next_us));
      work_until_us_ = next_us + firmware_->card.take_processor_us();
      next_loop_us_ = std::max(next_us + parameters_.loop_us, work_until_us_);
    }
  }
  now_us_ = std::max(now_us_, t_us);
}

// What the interrupt takes of the processor, the main loop does not get.
void LoggerBoard::sample(uint64_t t_us) {
  InterruptClock& clock = firmware_->interrupt_clock;
  const uint64_t before_us = clock.us;
  firmware_->inputs.set_now(board_us(t_us));
  firmware_->timer.pass();
  if (bring_world_) {
    clock.bring_world = [&, t_us, before_us] { bring_world_(t_us + clock.us - before_us); };
  }
  firmware_->core.sample(board_us(t_us));
  work_until_us_ = std::max(work_until_us_, t_us) + clock.us - before_us;
  next_loop_us_ = std::max(next_loop_us_, work_until_us_);
}

void LoggerBoard::set_switch(int index, bool closed, uint64_t t_us) {
  if (index < 0 || index > 1) return;
  switch_closed_[index] = closed;
  if (firmware_ != nullptr) firmware_->inputs.set_switch(index, !closed, board_us(t_us));
}

void LoggerBoard::stroke_edge(uint64_t t_us) {
  if (firmware_ != nullptr) firmware_->inputs.stroke(board_us(t_us));
}

void LoggerBoard::set_memory(const std::vector<uint8_t>& bytes) {
  memory_ = bytes;
  memory_.resize(kMemoryBytes, 0xFF);
}

void LoggerBoard::set_cable(bool plugged) {
  if (plugged == cable_) return;
  cable_ = plugged;
  if (firmware_ != nullptr) firmware_->stream.set_connected(plugged);
}

size_t LoggerBoard::write(const uint8_t* data, size_t n) {
  return firmware_ != nullptr ? firmware_->stream.host_write(data, n) : 0;
}

size_t LoggerBoard::read(uint8_t* data, size_t capacity) {
  return firmware_ != nullptr ? firmware_->stream.host_read(data, capacity) : 0;
}

}  // namespace emulator
}  // namespace tfsat
