// A robot that waits for longer than a file lasts.
#include "board_bench.h"

using namespace tfsat;
using namespace tfsat::protocol;
using emulator::CardDefect;
using tfsat_test::events_of;
using tfsat_test::Recording;
using Bench = tfsat_test::BoardBench;

namespace {

// At 1 kHz 2 MiB last for a drop of 11 s, its second copy, and 8 s before.
LoggerSettings small() {
  LoggerSettings settings = logger::factory_settings();
  settings.rate_hz = 1000;
  settings.file_mib = 2;
  settings.after_landing_s = 5;
  return settings;
}

Recording file(const Bench& bench, uint16_t number) {
  const std::vector<uint8_t> bytes = bench.card.file(number);
  std::vector<logger::Block> blocks(bytes.size() / kBlockBytes);
  for (size_t i = 0; i < blocks.size(); ++i) {
    std::memcpy(blocks[i].bytes, bytes.data() + i * kBlockBytes, kBlockBytes);
  }
  return tfsat_test::read_recording(blocks, blocks.size());
}

// When the first file ends, by a run that nobody disturbs.
uint64_t first_file_ends_us() {
  Bench bench;
  bench.write_settings(small());
  bench.start(1);
  bench.run_ms(12000);
  return file(bench, 1).sample_times_us.back();
}

}  // namespace

TEST_CASE(a_full_file_goes_on_in_the_next_and_a_stop_ends_it) {
  Bench bench;
  bench.write_settings(small());
  const uint32_t session = bench.start(1).session;
  bench.run_ms(20000);
  CHECK(bench.status().state == LoggerState::kRecording && bench.status().session != session);
  CHECK(bench.start(1).session == bench.status().session);  // a late copy of the first start
  bench.stop();
  bench.run_ms(500);
  CHECK(bench.status().state == LoggerState::kStopped);
  CHECK(file(bench, 3).footers.at(0).stop_reason == StopReason::kHost);
  CHECK(bench.card.file(4).empty());
  uint64_t last_us = 0;
  for (uint16_t number = 1; number <= 3; ++number) {
    const Recording log = file(bench, number);
    CHECK(log.samples.size() == log.footers.at(0).samples && log.headers.size() > 1);
    if (number < 3) CHECK(log.footers[0].stop_reason == StopReason::kFileFull);
    if (number > 1) CHECK(log.sample_times_us.front() - last_us < 50000);
    last_us = log.sample_times_us.back();
  }
}

TEST_CASE(a_card_gone_at_the_change_of_files_leaves_the_drop_in_ram) {
  const uint64_t end_us = first_file_ends_us();
  for (const int64_t offset_us : {-3000000, -200000, -1000, 0, 500, 1000, 1500, 2500}) {
    Bench bench;
    bench.write_settings(small());
    bench.start(1);
    bench.run_until(static_cast<uint64_t>(static_cast<int64_t>(end_us) + offset_us));
    bench.card.set_present(false);
    bench.run_ms(12000);
    CHECK(bench.status().state == LoggerState::kFailed);
    bench.release();
    bench.run_ms(2500);
    bench.land();
    bench.run_ms(6000);
    CHECK(bench.status().ram_holds_drop == 1);
  }
}

TEST_CASE(a_card_without_room_for_the_next_file_leaves_the_drop_in_ram) {
  Bench bench;
  bench.write_settings(small());
  bench.start(1);
  bench.card.fill_up_to(100);
  bench.run_ms(12000);
  CHECK(bench.status().state == LoggerState::kFailed);
  CHECK(bench.status().error == ErrorCode::kCardFull && bench.status().card == CardState::kFull);
  bench.release();
  bench.run_ms(2500);
  bench.land();
  bench.run_ms(6000);
  CHECK(bench.status().ram_holds_drop == 1);
}
