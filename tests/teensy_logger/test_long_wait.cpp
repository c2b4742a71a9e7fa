// A robot that waits for longer than a file lasts, and a processor that sampling and a slow card share meanwhile.
#include "shared_processor.h"

using namespace tfsat_test;
using tfsat::logger::kRingBlocks;

namespace {

constexpr uint32_t kDearNs = 30000;
constexpr uint16_t kManeuverCrc = 0xBEEF;

// At 1 kHz 2 MiB last for a drop of 11 s, its second copy, and 8 s before.
struct SmallFile : BoardBench {
  SmallFile() {
    LoggerSettings settings = logger::factory_settings();
    settings.rate_hz = 1000;
    settings.file_mib = 2;
    settings.after_landing_s = 5;
    write_settings(settings);
    session = start({1, 0, 1, kManeuverCrc}).session;
  }
  void check_ram_keeps_the_drop() {
    run_ms(12000);
    CHECK(status().state == LoggerState::kFailed);
    drop(6000);
    CHECK(status().ram_holds_drop == 1);
  }
  uint32_t session;
};

}  // namespace

TEST_CASE(a_full_file_goes_on_in_the_next_and_a_stop_ends_it) {
  SmallFile bench;
  bench.run_ms(20000);
  CHECK(bench.status().state == LoggerState::kRecording && bench.status().session != bench.session);
  CHECK(bench.start(1).session == bench.status().session);  // a late copy of the first start
  CHECK(bench.refused(RecordStartRequest{2, 0, 1, 0x1234}).code == ErrorCode::kWrongState);
  bench.stop();
  bench.run_ms(500);
  CHECK(bench.status().state == LoggerState::kStopped);
  CHECK(bench.file(3).footers.at(0).stop_reason == StopReason::kHost);
  CHECK(bench.card.file(4).empty());
  uint64_t last_us = 0;
  for (uint16_t number = 1; number <= 3; ++number) {
    const Recording log = bench.file(number);
    CHECK(log.samples.size() == log.footers.at(0).samples && log.headers.size() > 1);
    for (const LogHeader& header : log.headers) {
      CHECK(header.maneuver_known == 1 && header.maneuver_crc == kManeuverCrc);
    }
    if (number < 3) CHECK(log.footers[0].stop_reason == StopReason::kFileFull);
    if (number > 1) CHECK(log.sample_times_us.front() - last_us < 50000);
    last_us = log.sample_times_us.back();
  }
}

// Just before the file's end, between two files, and just after.
TEST_CASE(a_card_gone_at_the_change_of_files_leaves_the_drop_in_ram) {
  SmallFile undisturbed;
  undisturbed.run_ms(12000);
  const uint64_t end_us = undisturbed.file(1).sample_times_us.back();
  for (const int offset_us : {-200000, 0, 1000}) {
    SmallFile bench;
    bench.run_until(end_us + static_cast<uint64_t>(offset_us));
    bench.card.set_present(false);
    bench.check_ram_keeps_the_drop();
  }
}

TEST_CASE(a_card_without_room_for_the_next_file_leaves_the_drop_in_ram) {
  SmallFile bench;
  bench.card.fill_up_to(100);
  bench.check_ram_keeps_the_drop();
  CHECK(bench.status().error == ErrorCode::kCardFull && bench.status().card == CardState::kFull);
}

// Whatever blocks cost, and when one in a hundred stalls.
TEST_CASE(the_factory_file_is_recorded_at_every_rate) {
  const struct {
    uint16_t rate_hz;
    uint32_t stall_one_in;
  } cases[] = {{280, 0}, {1000, 0}, {280, 100}, {1000, 100}};
  for (const auto& c : cases) {
    SharedProcessor bench(c.rate_hz, kFileFactoryMib, kDearNs, c.stall_one_in);
    bench.run_ms(c.stall_one_in == 0 ? 11000 : 15000);
    CHECK(bench.records_all() && bench.blocks_to_spare() > kRingBlocks / (c.stall_one_in == 0 ? 2 : 4));
    CHECK(bench.stop().samples_dropped == 0 && bench.log().footers.size() == 1);
  }
}

TEST_CASE(what_is_recorded_while_the_file_is_filled_is_soon_safe) {
  SharedProcessor bench(1000, kFileFactoryMib, kDearNs, 0);
  for (int i = 0; i < 4; ++i) {
    bench.run_ms(1310);
    emulator::BlockDevice cut = bench.card;
    cut.power_cut(emulator::PowerCut::kLosesCache);
    CHECK(bench.recording_in(cut.bytes()).samples.size() + 600 > bench.status().samples);
  }
}

TEST_CASE(a_drop_right_after_the_start_is_recorded_whole_and_twice) {
  for (const uint64_t after_ms : {50, 1500}) {
    SharedProcessor bench(1000, kFileFactoryMib, kDearNs, 0);
    bench.run_ms(after_ms);
    bench.drop(7000);
    CHECK(bench.status().state == LoggerState::kStopped && bench.status().samples_dropped == 0);
    const Recording log = bench.log();
    CHECK(log.footers.size() == 1 && log.footers[0].blocks_rewritten > 500);
    CHECK(log.sample_indices.back() + 1 == log.samples.size());
  }
}

TEST_CASE(a_card_that_is_counted_for_4_s_leaves_no_request_without_an_answer) {
  BoardBench bench;
  for (const bool card_changed : {false, true}) {
    bench.card.set_mount_us(4000000);
    if (card_changed) {
      bench.card.set_present(false);
      bench.run_ms(2500);
      bench.card.set_present(true);
    } else {
      bench.board.set_power(false);
      bench.board.set_power(true);
    }
    bench.run_ms(2100);  // the card is looked at every 2 s
    for (int i = 0; i < 60; ++i) {
      CHECK(bench.status().card == CardState::kUnknown);
      CHECK(bench.get<HelloReply>(HelloRequest::kType).board == Board::kLogger);
      CHECK(bench.refused(RecordStartRequest{7, 0, 0, 0}).code == ErrorCode::kBusy);
      CHECK(bench.refused(LogListRequest{0}).code == ErrorCode::kBusy);
    }
    bench.run_ms(3000);
    CHECK(bench.status().card == CardState::kReady);
  }
  CHECK(bench.start(7).state == LoggerState::kRecording);
  bench.run_ms(1000);
  CHECK(bench.stop().samples_dropped == 0);
}
