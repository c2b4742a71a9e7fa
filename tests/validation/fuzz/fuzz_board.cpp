// The whole sequencer in virtual time, in the hands of a script: garbage and good frames on the link, switches,
// cable, resets and power cuts at any moment. What must hold stands in judged_bench.h, and at the ports themselves.
#include "judged_bench.h"

using namespace tfsat::protocol;
using tfsat_fuzz::JudgedBench;
using tfsat_test::Bytes;

namespace {

// A fuzzer's input as a script: numbers one after the other. After its end come zeros.
class Script {
 public:
  Script(const uint8_t* data, size_t size) : data_(data), left_(size) {}

  bool done() const { return left_ == 0; }

  uint8_t u8() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  uint16_t u16() {
    const unsigned low = u8();
    return static_cast<uint16_t>(low | static_cast<unsigned>(u8()) << 8);
  }

  // Fills `out` from the script, the rest with zeros.
  void bytes(uint8_t* out, size_t size) {
    const size_t given = std::min(size, left_);
    std::copy_n(data_, given, out);
    std::fill(out + given, out + size, static_cast<uint8_t>(0));
    data_ += given;
    left_ -= given;
  }

 private:
  const uint8_t* data_;
  size_t left_;
};

// Bounds the time of one input: a script of nothing but waiting teaches nothing.
constexpr int kMostLoops = 1500;

// Requests of the sequencer, and one that it does not know.
struct Request {
  uint8_t type;
  size_t size;
};
template <typename Message>
constexpr Request request() {
  return Request{Message::kType, Message::kSize};
}
constexpr Request kRequests[] = {
    request<HelloRequest>(),         request<SequencerStatusRequest>(), request<RunReportRequest>(),
    request<ManeuverBeginRequest>(), request<ManeuverStrokeRequest>(),  request<ManeuverCommitRequest>(),
    request<ManeuverInfoRequest>(),  request<ManeuverReadRequest>(),    request<SettingsWriteRequest>(),
    request<SettingsReadRequest>(),  request<ArmRequest>(),             request<DisarmRequest>(),
    request<JointReportRequest>(),   request<JogRequest>(),             request<LiveRequest>(),
};

template <typename Message>
void send(JudgedBench& bench, const Message& message) {
  Bytes payload(Message::kSize);
  message.encode(payload.data());
  bench.send(Message::kType, payload);
}

void write_garbage(Script& script, JudgedBench& bench) {
  Bytes garbage(script.u8() % 64 + 1);
  script.bytes(garbage.data(), garbage.size());
  bench.write(garbage);
}

// A frame whose CRC is right, of the right length or not, with any payload.
void send_any(Script& script, JudgedBench& bench) {
  const Request& kind = kRequests[script.u8() % (sizeof kRequests / sizeof kRequests[0])];
  const uint8_t length = script.u8();
  Bytes payload(length < 0x80 ? kind.size : length % (kMaxPayloadBytes + 1));
  script.bytes(payload.data(), payload.size());
  bench.send(kind.type, payload);
}

void send_arm(Script& script, JudgedBench& bench) {
  ArmRequest arm;
  const uint8_t error = script.u8();
  arm.arm_token = static_cast<uint16_t>(bench.arm_token() + (error < 0xC0 ? 0 : error - 0xE0));
  send(bench, arm);
}

// Two strokes of joint 1 and 2 and so on; what the script adds makes them wrong or only different.
void send_maneuver(Script& script, JudgedBench& bench) {
  ManeuverBeginRequest begin;
  begin.stroke_count = script.u8();
  if (begin.stroke_count < 0xF0) begin.stroke_count = static_cast<uint8_t>(begin.stroke_count % kMaxStrokes + 1);
  begin.speed_cdeg_s = static_cast<uint16_t>(17000 ^ script.u16());
  send(bench, begin);
  Bytes canonical = {begin.stroke_count, static_cast<uint8_t>(begin.speed_cdeg_s),
                     static_cast<uint8_t>(begin.speed_cdeg_s >> 8)};
  for (uint8_t i = 0; i < begin.stroke_count && i < kMaxStrokes; ++i) {
    ManeuverStrokeRequest stroke;
    stroke.index = i;
    stroke.joint = static_cast<uint8_t>((1 + i % 2) ^ script.u8());
    stroke.angle_cdeg = static_cast<int16_t>((i % 4 < 2 ? 1000 : -1000) ^ script.u16());
    stroke.start_us = kPauseMinUs + i * 100000u + script.u16();
    send(bench, stroke);
    uint8_t payload[ManeuverStrokeRequest::kSize];
    stroke.encode(payload);
    canonical.insert(canonical.end(), payload + 1, payload + sizeof payload);
  }
  ManeuverCommitRequest commit;
  commit.crc = static_cast<uint16_t>(tfsat_test::reference_crc16(canonical.data(), canonical.size()) ^ script.u8());
  send(bench, commit);
}

void send_settings(Script& script, JudgedBench& bench) {
  const auto factory = tfsat::sequencer::Settings::factory();
  Bytes payload(SettingsWriteRequest::kSize);
  factory.encode(payload.data());
  Bytes changes(payload.size());
  script.bytes(changes.data(), script.u8() % (changes.size() + 1));
  for (size_t i = 0; i < payload.size(); ++i) payload[i] = static_cast<uint8_t>(payload[i] ^ changes[i]);
  bench.send(SettingsWriteRequest::kType, payload);
}

void send_jog(Script& script, JudgedBench& bench) {
  JogRequest jog;
  jog.joint = script.u8();
  if (jog.joint < 0xF0) jog.joint = static_cast<uint8_t>(jog.joint % kJointCount + 1);
  jog.from_cdeg = static_cast<int16_t>(script.u16());
  jog.to_cdeg = static_cast<int16_t>(script.u16());
  jog.confirm = kJogConfirm ^ script.u8();
  send(bench, jog);
}

// Turns of the main loop at once: the low five bits say how many, the others how long each takes.
int turn(Script& script, JudgedBench& bench) {
  constexpr uint32_t kTurnsUs[] = {50, 300, 1000, 3400, 5000, 20000, 50000, 200000};
  const uint8_t how = script.u8();
  const int count = how % 32 + 1;
  for (int i = 0; i < count; ++i) bench.loop(kTurnsUs[how / 32]);
  return count;
}

void set_switches(Script& script, JudgedBench& bench) {
  const uint8_t levels = script.u8();
  for (int i = 0; i < 2; ++i) {
    if (levels >> (i + 2) & 1) bench.set_switch(i, levels >> i & 1);
  }
}

void plug(Script& script, JudgedBench& bench) {
  const uint8_t how = script.u8();
  bench.set_cable(how & 1);
  bench.set_host_reads(how & 2);
}

void restart(Script& script, JudgedBench& bench) {
  constexpr ResetCause kCauses[] = {ResetCause::kWatchdog, ResetCause::kBrownOut, ResetCause::kExternal};
  const uint8_t cause = script.u8() % 4;
  if (cause < 3) {
    bench.reset(kCauses[cause]);
  } else {
    bench.cut_power();
  }
}

// Scripts in tests/validation/fuzz/seeds.py and corpus/ count on this order.
using Step = void (*)(Script&, JudgedBench&);
constexpr Step kSteps[] = {write_garbage, send_any, send_arm,     send_maneuver, send_settings,
                           send_jog,      plug,     set_switches, restart};
constexpr size_t kStepCount = sizeof kSteps / sizeof kSteps[0];  // the next numbers, up to 15, let time pass

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Script script(data, size);
  JudgedBench bench;
  int loops = 0;
  while (!script.done() && loops < kMostLoops) {
    const size_t step = script.u8() % 16;
    if (step < kStepCount) {
      kSteps[step](script, bench);
    } else {
      loops += turn(script, bench);
    }
  }
  bench.require_disarm();
  bench.cut_power();
  return 0;
}
