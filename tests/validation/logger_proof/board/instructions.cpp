// instructions RATE_HZ: how many instructions the logger takes for a sample and for a pass of the
// main loop, on a machine where an instruction takes a nanosecond and SysTick counts every 40 of
// them.
//
// The ports do as little as can be, and what they do is measured alone: "ports" times the calls.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <new>

#include "world.h"

namespace {

using namespace proof;
using tfsat::protocol::ErrorCode;

constexpr uint32_t kNsATick = 40;
volatile uint32_t* const kSysTick = reinterpret_cast<volatile uint32_t*>(0xE000E010);
constexpr uint32_t kSysTickMask = 0xFFFFFF;

void start_counting() {
  kSysTick[1] = kSysTickMask;
  kSysTick[2] = 0;
  kSysTick[0] = 5;  // enabled, processor clock, no interrupt
}

uint32_t instructions_since(uint32_t begin) {
  return ((begin - kSysTick[2]) & kSysTickMask) * kNsATick;
}

struct Calls {
  uint32_t reads, polls, adc, edges, switches;
} calls;

class QuietBus final : public tfsat::logger::I2cBus {
 public:
  void set_clock(uint16_t) override {}
  void start_read(uint8_t, uint8_t reg, uint8_t* data, uint8_t size) override {
    ++calls.reads;
    if (size == 14) {
      ++burst_[13];
      memcpy(data, burst_, sizeof burst_);
    } else if (reg == 0x75) {
      data[0] = 0x68;
    } else {
      memcpy(data, registers_ + reg, size);
    }
  }
  void start_write(uint8_t, uint8_t reg, uint8_t value) override { registers_[reg] = value; }
  tfsat::logger::I2cResult poll() override {
    ++calls.polls;
    return tfsat::logger::I2cResult::kDone;
  }
  void recover() override {}

 private:
  uint8_t burst_[14] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  uint8_t registers_[128] = {};
};

class QuietAdc final : public tfsat::logger::Adc {
 public:
  uint8_t read(uint16_t counts[6]) override {
    ++calls.adc;
    for (uint32_t i = 0; i < 6; ++i) counts[i] = static_cast<uint16_t>(i);
    return 0x3F;
  }
};

class QuietInputs final : public tfsat::logger::Inputs {
 public:
  bool take_edge(tfsat::logger::Edge&) override {
    ++calls.edges;
    return false;
  }
  uint8_t switches_open() override {
    ++calls.switches;
    return 0;
  }
};

class QuietTimer final : public tfsat::logger::SampleTimer {
 public:
  void start(uint16_t) override {}
  void stop() override {}
};

class QuietCard final : public tfsat::logger::BlockSink, public tfsat::logger::LogArchive {
 public:
  ErrorCode open(uint32_t n_blocks) override {
    prepared = n_blocks;
    return ErrorCode::kNone;
  }
  bool busy(uint64_t) override { return false; }
  ErrorCode prepare() override { return ErrorCode::kNone; }
  uint32_t prepared_blocks() override { return prepared; }
  ErrorCode recover(uint64_t) override { return ErrorCode::kNone; }
  ErrorCode write(uint32_t, const uint8_t*) override {
    ++written;
    return ErrorCode::kNone;
  }
  ErrorCode sync() override { return ErrorCode::kNone; }
  ErrorCode close(uint32_t) override { return ErrorCode::kNone; }
  ErrorCode inspect(uint32_t) override { return ErrorCode::kNone; }
  uint32_t free_mib() override { return 1000; }
  bool find(uint16_t, uint16_t&, uint32_t&) override { return false; }
  ErrorCode read(uint16_t, uint32_t, uint8_t*) override { return ErrorCode::kNoSuchLog; }
  ErrorCode erase(uint16_t) override { return ErrorCode::kNoSuchLog; }

  uint32_t written = 0;
  uint32_t prepared = 0;
};

struct Figure {
  uint32_t count = 0;
  uint64_t total = 0;
  uint32_t most = 0;

  void add(uint32_t instructions) {
    ++count;
    total += instructions;
    if (instructions > most) most = instructions;
  }
  void print(const char* name) const {
    const uint64_t mean = count == 0 ? 0 : total / count;
    printf("%s %lu %lu %lu\n", name, static_cast<unsigned long>(count),
           static_cast<unsigned long>(mean), static_cast<unsigned long>(most));
  }
};

QuietBus bus_a, bus_b;
QuietAdc adc;
QuietInputs inputs;
QuietTimer timer;
QuietCard card;
Memory memory;
Ram ram;
Cable cable(ram);
SessionIds ids(1);
tfsat::logger::Block ring[tfsat::logger::kRingBlocks];
constexpr uint32_t kPasses = 4;  // of the main loop between two samples

struct Figures {
  Figure sample, pass, pass_with_block;
};

void run(tfsat::logger::Logger& logger, uint64_t& t_us, uint32_t period_us, uint32_t samples,
         Figures& figures) {
  calls = Calls();
  for (uint32_t i = 0; i < samples; ++i) {
    t_us += period_us;
    uint32_t begin = kSysTick[2];
    logger.sample(t_us);
    figures.sample.add(instructions_since(begin));
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
      const uint32_t written = card.written;
      begin = kSysTick[2];
      logger.poll(t_us + pass * (period_us / kPasses));
      (card.written != written ? figures.pass_with_block : figures.pass)
          .add(instructions_since(begin));
    }
  }
}

// What the ports themselves take for one sample, and the reading of the clock.
uint32_t ports_alone(uint32_t samples) {
  tfsat::logger::I2cBus* volatile bus = &bus_a;
  tfsat::logger::Adc* volatile converter = &adc;
  tfsat::logger::Inputs* volatile pins = &inputs;
  uint8_t data[14];
  uint16_t counts[6];
  tfsat::logger::Edge edge;
  const Calls made = calls;
  constexpr uint32_t kTimes = 1000;
  uint32_t total = 0;
  for (uint32_t i = 0; i < kTimes; ++i) {
    const uint32_t begin = kSysTick[2];
    for (uint32_t k = 0; k < made.reads / samples; ++k) bus->start_read(0x68, 0x3B, data, 14);
    for (uint32_t k = 0; k < made.polls / samples; ++k) bus->poll();
    for (uint32_t k = 0; k < made.adc / samples; ++k) converter->read(counts);
    for (uint32_t k = 0; k < made.edges / samples; ++k) pins->take_edge(edge);
    for (uint32_t k = 0; k < made.switches / samples; ++k) pins->switches_open();
    total += instructions_since(begin);
  }
  return total / kTimes;
}

void send_settings(uint16_t rate_hz) {
  tfsat::protocol::LoggerSettingsWriteRequest request;
  request.settings = tfsat::logger::factory_settings();
  request.settings.rate_hz = rate_hz;
  cable.send(request);
}

void send_start() {
  tfsat::protocol::RecordStartRequest request = {};
  request.number = 1;
  request.unix_us = 0;
  cable.send(request);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const uint16_t rate_hz = static_cast<uint16_t>(strtoul(argv[1], nullptr, 10));
  const uint32_t period_us = 1000000u / rate_hz;
  static tfsat::logger::Logger logger(
      tfsat::logger::Ports{bus_a, bus_b, adc, inputs, timer, card, card, memory, cable, ids},
      tfsat::logger::Identity{}, ring, tfsat::logger::kRingBlocks);
  start_counting();
  logger.begin();
  uint64_t t_us = 0;
  Figures warming, idle, recording;
  send_settings(rate_hz);
  run(logger, t_us, period_us, rate_hz, warming);
  run(logger, t_us, period_us, rate_hz, idle);
  send_start();
  run(logger, t_us, period_us, rate_hz, warming);
  cable.pull();
  const uint32_t samples = 10u * rate_hz;
  run(logger, t_us, period_us, samples, recording);
  if (logger.state() != tfsat::protocol::LoggerState::kRecording || card.written == 0) return 1;
  const uint32_t ports = ports_alone(samples);
  idle.sample.print("idle_sample");
  recording.sample.print("sample");
  recording.pass.print("pass");
  recording.pass_with_block.print("pass_with_block");
  printf("ports 1 %lu %lu\n", static_cast<unsigned long>(ports), static_cast<unsigned long>(ports));
  return 0;
}
