#include "logger.h"

namespace tfsat {
namespace logger {

namespace {

// The greatest specific force on any axis of an IMU that is valid.
uint32_t peak_accel_counts(const protocol::Sample& sample) {
  uint32_t peak = 0;
  for (uint32_t i = 0; i < protocol::kImuCount; ++i) {
    if ((sample.flags & sample_flags::imu_valid(i)) == 0) continue;
    for (const int16_t accel : sample.imu[i].accel) {
      const uint32_t size = static_cast<uint32_t>(accel < 0 ? -int32_t{accel} : int32_t{accel});
      if (size > peak) peak = size;
    }
  }
  return peak;
}

}  // namespace

Logger::Logger(const Ports& ports, const Identity& identity, Block* ring_blocks,
               uint32_t ring_capacity)
    : sampler_(ports.bus_a, ports.bus_b, ports.adc, ports.inputs),
      recorder_(ring_blocks, ring_capacity, ports.card),
      inputs_(ports.inputs),
      timer_(ports.timer),
      settings_(ports.memory),
      card_watch_(ports.card),
      log_server_(ports.archive, recorder_),
      requests_(*this, identity,
                Parts{sampler_, ports.inputs, recorder_, ports.card, card_watch_, log_server_,
                      settings_}),
      link_(ports.stream, requests_),
      stream_(ports.stream),
      entropy_(ports.entropy) {}

void Logger::begin() {
  settings_.load();
  use_settings();
}

void Logger::use_settings() {
  timer_.stop();
  const protocol::LoggerSettings& settings = settings_.settings();
  sampler_.apply(settings);
  intervals_.reset(settings.rate_hz);
  timer_.start(settings.rate_hz);
}

// ------------------------------------------------------------------------------ sampling interrupt

void Logger::sample(uint64_t t_us) {
  sampler_.sample(t_us, instant_);
  collect_events(t_us);
  recorder_.capture(t_us, instant_.sample, events_);
  if (live_.load(std::memory_order_relaxed)) {
    protocol::LiveSampleStream live;
    live.index = sample_index_;
    live.time_us = t_us;
    live.sample = instant_.sample;
    live_samples_.push(live);  // full: skipped, which the index shows
  }
  ++sample_index_;
}

void Logger::collect_events(uint64_t t_us) {
  if (!recorder_.watching() || recorder_.session() != session_) {
    session_ = recorder_.session();
    strokes_ = 0;
    if (!recorder_.continued()) {
      events_.clear();
      edges_not_kept_ = 0;
    }
  }
  for (uint8_t i = 0; i < instant_.event_count; ++i) events_.push(instant_.events[i]);
  protocol::Event event = {};
  if (intervals_.add(t_us)) {
    late_ticks_.fetch_add(1, std::memory_order_relaxed);
    event.time_us = t_us;
    event.code = protocol::EventCode::kSamplingLate;
    event.value = static_cast<int32_t>(intervals_.last_interval_us());
    events_.push(event);
  }
  Edge edge;
  for (uint32_t i = 0; i < kEdgesAnInstant && inputs_.take_edge(edge); ++i) push_edge(edge);
  if (recorder_.watching()) {
    recorder_.watch().poll(t_us, inputs_.switches_open(), peak_accel_counts(instant_.sample));
  }
  while (events_.room() > kOwnEvents && recorder_.take_event(event)) events_.push(event);
}

// The watch must have every edge before it looks at the levels, with room for it in the log or not.
void Logger::push_edge(const Edge& edge) {
  if (recorder_.watching()) recorder_.watch().on_edge(edge);
  const bool is_stroke = edge.source == Edge::Source::kStroke;
  const uint8_t stroke = strokes_;
  if (is_stroke) ++strokes_;
  edges_not_kept_ += edge.lost;
  if (events_.room() <= kOwnEvents) {
    ++edges_not_kept_;
    return;
  }
  protocol::Event event = {};
  event.time_us = edge.t_us;
  event.value = static_cast<int32_t>(edges_not_kept_);
  edges_not_kept_ = 0;
  if (is_stroke) {
    event.code = protocol::EventCode::kStroke;
    event.index = stroke;
  } else {
    event.code = protocol::EventCode::kSwitchEdge;
    event.index = edge.index;
    event.arg = edge.open ? 1 : 0;
  }
  events_.push(event);
}

// --------------------------------------------------------------------------------------- main loop

void Logger::poll(uint64_t t_us) {
  recorder_.poll(t_us);
  // Looking at a card may take a second, and in a drop nobody reads the answer.
  const bool drop = recorder_.capturing() && recorder_.phase() != protocol::DropPhase::kWaiting;
  if (!recorder_.uses_card() && !drop) {
    card_watch_.poll(t_us, file_blocks(settings_.settings()));
  }
  requests_.set_now(t_us);
  if (recorder_.wants_next_file()) requests_.start_next_file();
  link_.poll();
  if (!stream_.connected()) {
    live_ = false;
    log_server_.end();
  }
  send_live();
  for (uint8_t i = 0; i < kLogFrames && log_server_.poll(link_); ++i) continue;
}

void Logger::send_live() {
  if (!live_) {
    live_samples_.clear();
    return;
  }
  uint8_t payload[protocol::LiveSampleStream::kSize];
  for (const protocol::LiveSampleStream* sample = live_samples_.front(); sample != nullptr;
       sample = live_samples_.front()) {
    sample->encode(payload);
    if (!link_.send_stream(protocol::LiveSampleStream::kType, payload, sizeof payload)) return;
    live_samples_.pop();
  }
}

bool Logger::light(uint64_t t_us) const {
  using protocol::CardState;
  constexpr uint8_t kAllImus = (1u << protocol::kImuCount) - 1;
  const uint32_t t_ms = static_cast<uint32_t>(t_us / 1000);
  const bool card_bad = !recorder_.uses_card() && card_watch_.state() != CardState::kReady &&
                        card_watch_.state() != CardState::kUnknown;
  if (state() == protocol::LoggerState::kFailed || sampler_.imu_present() != kAllImus || card_bad) {
    return t_ms % 200 < 100;
  }
  if (state() == protocol::LoggerState::kRecording) return true;
  return t_ms % 2000 < 50;
}

bool Logger::apply(const protocol::LoggerSettings& settings) {
  if (!settings_.store(settings)) return false;
  use_settings();
  return true;
}

// 0 stands for "none yet".
uint32_t Logger::new_session() {
  const uint32_t session = entropy_.next();
  return session != 0 ? session : 1;
}

}  // namespace logger
}  // namespace tfsat
