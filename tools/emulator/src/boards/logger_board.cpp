#include "logger_board.h"

#include <algorithm>
#include <deque>

namespace tfsat {
namespace emulator {

using protocol::ErrorCode;

namespace {

constexpr size_t kLinkBytes = 8192;  // each direction; USB buffers on the board and at the host

class BusPort final : public logger::I2cBus {
 public:
  explicit BusPort(emulator::I2cBus& bus) : bus_(bus) {}

  void start_read(uint8_t address, uint8_t reg, uint8_t* data, uint8_t size) override {
    result_ = result(bus_.read(address, reg, data, size));
  }
  void start_write(uint8_t address, uint8_t reg, uint8_t value) override {
    result_ = result(bus_.write(address, reg, &value, 1));
  }
  logger::I2cResult poll() override { return result_; }
  void recover() override { bus_.clock_free(); }

 private:
  logger::I2cResult result(bool acknowledged) const {
    if (bus_.stuck()) return logger::I2cResult::kStuck;
    return acknowledged ? logger::I2cResult::kDone : logger::I2cResult::kNack;
  }

  emulator::I2cBus& bus_;
  logger::I2cResult result_ = logger::I2cResult::kDone;
};

class AdcPort final : public logger::Adc {
 public:
  AdcPort(std::vector<AngleSensor>& sensors,
          const std::array<double, protocol::kAngleSensorCount>& joint_angle_rad)
      : sensors_(sensors), joint_angle_rad_(joint_angle_rad) {}

  uint8_t read(uint16_t counts[protocol::kAngleSensorCount]) override {
    uint8_t converted = 0;
    for (size_t i = 0; i < sensors_.size() && i < joint_angle_rad_.size(); ++i) {
      counts[i] = sensors_[i].convert(joint_angle_rad_[i]);
      converted |= static_cast<uint8_t>(1u << i);
    }
    return converted;
  }

 private:
  std::vector<AngleSensor>& sensors_;
  const std::array<double, protocol::kAngleSensorCount>& joint_angle_rad_;
};

class InputsPort final : public logger::Inputs {
 public:
  bool take_edge(logger::Edge& edge) override {
    if (edges_.empty() || edges_.front().t_us > now_us_) return false;
    edge = edges_.front();
    edges_.pop_front();
    return true;
  }
  uint8_t switches_open() override { return open_; }

  // An edge is there for the board once its time has come.
  void set_now(uint64_t t_us) { now_us_ = t_us; }
  void set_switch(int index, bool open, uint64_t t_us) {
    const uint8_t bit = static_cast<uint8_t>(1u << index);
    if (((open_ & bit) != 0) == open) return;
    open_ ^= bit;
    edges_.push_back({t_us, logger::Edge::Source::kSwitch, static_cast<uint8_t>(index), open, 0});
  }
  void stroke(uint64_t t_us) {
    edges_.push_back({t_us, logger::Edge::Source::kStroke, 0, true, 0});
  }
  void preset(int index, bool open) {
    const uint8_t bit = static_cast<uint8_t>(1u << index);
    open_ = static_cast<uint8_t>(open ? open_ | bit : open_ & ~bit);
  }

 private:
  std::deque<logger::Edge> edges_;
  uint64_t now_us_ = 0;
  uint8_t open_ = 0;
};

class CardPort final : public logger::BlockSink {
 public:
  explicit CardPort(BlockDevice& card) : card_(card) {}

  ErrorCode open(uint32_t n_blocks) override { return error_of(card_.preallocate(n_blocks)); }
  ErrorCode poll(uint64_t t_us) override {
    t_us_ = t_us;
    return ErrorCode::kNone;
  }
  bool busy() override { return card_.busy(world_us()); }
  ErrorCode recover(uint64_t t_us) override {
    t_us_ = t_us;
    return card_.present() ? ErrorCode::kNone : ErrorCode::kNoCard;
  }
  ErrorCode write(uint32_t index, const uint8_t* block) override {
    return error_of(card_.write(world_us(), index, block));
  }
  ErrorCode sync() override { return error_of(card_.sync(world_us())); }
  ErrorCode close(uint32_t n_blocks) override { return error_of(card_.truncate(n_blocks)); }

  void set_powered_at(uint64_t t_us) { powered_us_ = t_us; }

 private:
  uint64_t world_us() const { return powered_us_ + t_us_; }
  static ErrorCode error_of(CardResult result) {
    switch (result) {
      case CardResult::kOk: return ErrorCode::kNone;
      case CardResult::kAbsent: return ErrorCode::kNoCard;
      case CardResult::kOutOfRange: return ErrorCode::kCardFull;
      case CardResult::kBusy: break;
    }
    return ErrorCode::kCardWriteFailed;
  }

  BlockDevice& card_;
  uint64_t powered_us_ = 0;
  uint64_t t_us_ = 0;
};

class StreamPort final : public protocol::ByteStream {
 public:
  bool connected() override { return connected_; }
  int read() override {
    if (to_board_.empty()) return -1;
    const uint8_t byte = to_board_.front();
    to_board_.pop_front();
    return byte;
  }
  size_t write(const uint8_t* data, size_t size) override { return push(to_host_, data, size); }

  void set_connected(bool connected) {
    connected_ = connected;
    to_board_.clear();
    to_host_.clear();
  }
  size_t host_write(const uint8_t* data, size_t n) {
    return connected_ ? push(to_board_, data, n) : 0;
  }
  size_t host_read(uint8_t* data, size_t capacity) {
    const size_t n = std::min(capacity, to_host_.size());
    std::copy_n(to_host_.begin(), n, data);
    to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }

 private:
  static size_t push(std::deque<uint8_t>& queue, const uint8_t* data, size_t n) {
    const size_t taken = std::min(n, kLinkBytes - queue.size());
    queue.insert(queue.end(), data, data + taken);
    return taken;
  }

  std::deque<uint8_t> to_board_;
  std::deque<uint8_t> to_host_;
  bool connected_ = false;
};

// splitmix64 (Steele, Lea & Flood, OOPSLA 2014).
class SeededEntropy final : public logger::Entropy {
 public:
  explicit SeededEntropy(uint64_t seed) : state_(seed) {}
  uint32_t next() override {
    uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return static_cast<uint32_t>((z ^ (z >> 31)) >> 32);
  }

 private:
  uint64_t state_;
};

}  // namespace

// What is gone when the power goes.
class LoggerBoard::Firmware {
 public:
  Firmware(LoggerBoard& board, uint64_t seed)
      : bus_a((*board.buses_)[0]),
        bus_b((*board.buses_)[1]),
        adc(*board.angle_sensors_, board.joint_angle_rad_),
        card(*board.card_),
        entropy(seed),
        core(logger::Ports{bus_a, bus_b, adc, inputs, card, stream, entropy},
             board.parameters_.identity, settings(board.parameters_), board.ring_.data(),
             static_cast<uint32_t>(board.ring_.size())) {}

  static logger::Settings settings(const LoggerBoardParameters& parameters) {
    logger::Settings result;
    result.file_blocks = parameters.file_blocks;
    return result;
  }

  BusPort bus_a;
  BusPort bus_b;
  AdcPort adc;
  InputsPort inputs;
  CardPort card;
  StreamPort stream;
  SeededEntropy entropy;
  logger::Logger core;
};

LoggerBoard::LoggerBoard(uint64_t seed, const LoggerBoardParameters& parameters)
    : seed_(seed), parameters_(parameters), ring_(logger::kRingBlocks) {}

LoggerBoard::~LoggerBoard() = default;

void LoggerBoard::attach(std::array<I2cBus, 2>& buses, std::vector<AngleSensor>& angle_sensors,
                         BlockDevice& card) {
  buses_ = &buses;
  angle_sensors_ = &angle_sensors;
  card_ = &card;
}

void LoggerBoard::set_joint_angle(int sensor, double angle_rad) {
  joint_angle_rad_.at(static_cast<size_t>(sensor)) = angle_rad;
}

void LoggerBoard::set_power(bool on) {
  if (on == (firmware_ != nullptr) || card_ == nullptr) return;
  if (!on) {
    firmware_.reset();
    return;
  }
  powered_us_ = now_us_;
  sample_count_ = 0;
  next_loop_us_ = now_us_;
  const uint64_t seed = seed_ + (boots_++ << 32);  // other session ids after each start
  firmware_ = std::make_unique<Firmware>(*this, seed);
  firmware_->card.set_powered_at(powered_us_);
  firmware_->stream.set_connected(cable_);
  for (int i = 0; i < 2; ++i) firmware_->inputs.preset(i, !switch_closed_[i]);
}

uint64_t LoggerBoard::next_sample_us() const {
  if (firmware_ == nullptr) return UINT64_MAX;
  return powered_us_ + (sample_count_ + 1) * 1000000u / protocol::kSampleRateHz;
}

void LoggerBoard::advance_to(uint64_t t_us) {
  while (firmware_ != nullptr) {
    const uint64_t next_us = std::min(next_sample_us(), next_loop_us_);
    if (next_us > t_us) break;
    if (next_us == next_sample_us()) {
      firmware_->inputs.set_now(board_us(next_us));
      firmware_->core.sample(board_us(next_us));
      ++sample_count_;
    } else {
      firmware_->core.poll(board_us(next_us));
      next_loop_us_ += parameters_.loop_us;
    }
  }
  now_us_ = std::max(now_us_, t_us);
}

void LoggerBoard::set_switch(int index, bool closed, uint64_t t_us) {
  if (index < 0 || index > 1) return;
  switch_closed_[index] = closed;
  if (firmware_ != nullptr) firmware_->inputs.set_switch(index, !closed, board_us(t_us));
}

void LoggerBoard::stroke_edge(uint64_t t_us) {
  if (firmware_ != nullptr) firmware_->inputs.stroke(board_us(t_us));
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
