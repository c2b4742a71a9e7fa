// Recordings over the cable: listed, read in windows, erased; to a host that reads slowly, closes its
// port or asks for what is not there.
#include <initializer_list>

#include "log_bench.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::kUnixUs;
using tfsat_test::recording_of;
using Bench = tfsat_test::LogBench;

TEST_CASE(the_list_begins_with_ram_and_goes_on_in_order) {
  Bench bench;
  CHECK(bench.list(0).found == 0);
  bench.archive.put_file(7, recording_of(70, 20));
  bench.archive.put_file(3, recording_of(30, 5));
  CHECK(bench.list(0).found == 1 && bench.list(0).entry.number == 3);
  bench.recorder.start(1, 10);
  bench.recorder.run_us(300000);
  bench.recorder.stop_and_read();
  const LogEntry ram = bench.list(0).entry;
  CHECK(ram.number == 0 && ram.session == 10 && ram.closed == 1);
  CHECK(ram.blocks == bench.recorder.recorder.ram_blocks() && ram.wall_clock_us == 0);
  const LogEntry third = bench.list(1).entry;
  CHECK(third.number == 3 && third.session == 30 && third.blocks == 7 && third.closed == 1);
  CHECK(third.wall_clock_us == kUnixUs);
  CHECK(bench.list(4).entry.number == 7 && bench.list(7).entry.session == 70);
  CHECK(bench.list(8).found == 0);
}

TEST_CASE(a_recording_that_was_cut_or_torn_is_listed_with_what_is_known) {
  Bench bench;
  std::vector<Block> cut = recording_of(40, 5);
  cut.back() = Block();
  bench.archive.put_file(4, cut);
  CHECK(bench.list(4).entry.closed == 0 && bench.list(4).entry.session == 40);
  cut[0].bytes[100] ^= 1;
  bench.archive.put_file(4, cut);
  const LogEntry torn = bench.list(4).entry;
  CHECK(torn.blocks == cut.size() && torn.session == 0 && torn.wall_clock_us == 0);
  CHECK(bench.read(4, 0, 0, 9) == ErrorCode::kNone);
  bench.run();
  CHECK(bench.got(cut, 0, static_cast<uint32_t>(cut.size())));
  bench.archive.put_file(5, {});
  CHECK(bench.list(5).found == 1 && bench.list(5).entry.blocks == 0);
  CHECK(bench.read(5, 0, 0, 1) == ErrorCode::kNoSuchLog);
}

TEST_CASE(windows_give_exactly_their_blocks) {
  Bench bench;
  const std::vector<Block> file = recording_of(1, 300);
  bench.archive.put_file(1, file);
  const uint32_t n = static_cast<uint32_t>(file.size());
  struct Window {
    uint32_t first;
    uint16_t asked;
    uint32_t given;
  };
  for (const Window& window :
       {Window{0, 1, 1}, Window{5, 100, 100}, Window{0, 1000, kLogReadBlocks}, Window{n - 1, 5, 1},
        Window{n - 3, 3, 3}, Window{0, 0, 0}}) {
    bench.forget();
    CHECK(bench.read(1, 1, window.first, window.asked) == ErrorCode::kNone);
    CHECK(bench.announced == window.given);
    bench.run();
    CHECK(bench.got(file, window.first, window.given));
  }
  CHECK(bench.read(1, 1, n, 1) == ErrorCode::kNoSuchLog);
  CHECK(bench.read(1, 1, UINT32_MAX, 65535) == ErrorCode::kNoSuchLog);
}

TEST_CASE(a_host_that_reads_slowly_gets_every_byte_once) {
  for (const size_t bytes_a_pass : {1u, 3u, 64u, 99u}) {
    Bench bench;
    std::vector<Block> file = recording_of(1, 12);
    file.resize(40);  // zeros
    file[20] = file[1];
    bench.archive.put_file(1, file);
    CHECK(bench.read(1, 1, 0, 40) == ErrorCode::kNone);
    bench.run(bytes_a_pass);
    CHECK(bench.got(file, 0, 40));
  }
}

TEST_CASE(zeros_go_in_runs) {
  Bench bench;
  std::vector<Block> file = recording_of(1, 2);  // 4 blocks
  file.resize(60);
  file.push_back(file[1]);
  file.resize(128);
  bench.archive.put_file(1, file);
  CHECK(bench.read(1, 1, 0, 128) == ErrorCode::kNone);
  bench.run();
  CHECK(bench.got(file, 0, 128));
  CHECK(bench.frames == 8 * 5 + 4 + 5);  // 56 and 67 zero blocks, 16 a run
}

TEST_CASE(ram_is_read_like_a_file) {
  Bench bench;
  bench.recorder.card.open_error = ErrorCode::kNoCard;
  bench.recorder.start(1, 10);
  bench.recorder.release_after_us(3000000);
  bench.recorder.run_us(100000);
  bench.recorder.recorder.stop();
  bench.recorder.tick();
  const std::vector<Block> ram = bench.recorder.ram();
  CHECK(ram.size() == 63);
  CHECK(bench.list(0).entry.closed == 0 && bench.list(0).entry.session == 10);
  CHECK(bench.read(0, 9, 0, 5) == ErrorCode::kLogChanged);
  CHECK(bench.read(0, 10, 0, 100) == ErrorCode::kNone);
  bench.run();
  CHECK(bench.got(ram, 0, 63));
  LogEraseRequest erase = {};
  erase.session = 9;
  CHECK(bench.server.erase(erase) == ErrorCode::kLogChanged);
  CHECK(bench.recorder.recorder.ram_holds_drop());
  erase.session = 10;
  CHECK(bench.server.erase(erase) == ErrorCode::kNone);
  CHECK(!bench.recorder.recorder.ram_holds_drop());
}

TEST_CASE(another_recording_under_the_number_is_neither_read_nor_erased) {
  Bench bench;
  bench.archive.put_file(2, recording_of(20, 5));
  CHECK(bench.read(2, 21, 0, 5) == ErrorCode::kLogChanged);
  CHECK(bench.read(3, 20, 0, 5) == ErrorCode::kNoSuchLog);
  LogEraseRequest erase = {};
  erase.number = 2;
  erase.session = 21;
  CHECK(bench.server.erase(erase) == ErrorCode::kLogChanged);
  CHECK(bench.archive.device.next_file(1) == 2);
  erase.session = 20;
  CHECK(bench.server.erase(erase) == ErrorCode::kNone);
  CHECK(bench.archive.device.next_file(1) == 0);
  CHECK(bench.server.erase(erase) == ErrorCode::kNoSuchLog);
  bench.run();
  CHECK(bench.frames == 0);
}

TEST_CASE(a_block_that_cannot_be_read_ends_the_window_and_then_says_why) {
  Bench bench;
  const std::vector<Block> file = recording_of(1, 20);
  bench.archive.put_file(1, file);
  bench.archive.unreadable = {6};
  CHECK(bench.read(1, 1, 0, 15) == ErrorCode::kNone);
  bench.run();
  CHECK(bench.got(file, 0, 6));
  CHECK(bench.read(1, 1, 6, 15) == ErrorCode::kCardWriteFailed);
  bench.run();
  CHECK(bench.got(file, 0, 6));
  bench.forget();
  CHECK(bench.read(1, 1, 7, 10) == ErrorCode::kNone);
  bench.run();
  CHECK(bench.got(file, 7, 10));
}

TEST_CASE(zeros_before_a_block_that_cannot_be_read_still_come) {
  Bench bench;
  std::vector<Block> file = recording_of(1, 2);
  file.resize(40);
  bench.archive.put_file(1, file);
  bench.archive.unreadable = {9};
  CHECK(bench.read(1, 1, 4, 30) == ErrorCode::kNone);
  bench.run();
  CHECK(bench.got(file, 4, 5));
}

TEST_CASE(a_new_read_ends_the_old_and_a_list_in_between_harms_nothing) {
  Bench bench;
  const std::vector<Block> first = recording_of(1, 100), second = recording_of(2, 100);
  bench.archive.put_file(1, first);
  bench.archive.put_file(2, second);
  bench.read(1, 1, 0, 100);
  for (int i = 0; i < 13; ++i) CHECK(bench.server.poll(bench.link));
  CHECK(bench.list(2).entry.session == 2);  // reads other blocks
  bench.run();
  bench.parts[1] = 8;  // begun again after the list
  CHECK(bench.got(first, 0, 100));
  bench.forget();
  bench.read(1, 1, 0, 100);
  for (int i = 0; i < 13; ++i) CHECK(bench.server.poll(bench.link));
  bench.receive();
  bench.forget();
  bench.read(2, 2, 50, 3);
  bench.run();
  CHECK(bench.got(second, 50, 3));
}

TEST_CASE(what_was_ended_sends_nothing_more) {
  Bench bench;
  bench.archive.put_file(1, recording_of(1, 50));
  bench.read(1, 1, 0, 50);
  CHECK(bench.server.poll(bench.link));
  bench.stream.plugged = false;
  CHECK(!bench.server.poll(bench.link));
  bench.server.end();
  bench.stream.plugged = true;
  bench.run();
  CHECK(bench.frames == 1);
  bench.read(1, 1, 0, 50);
  CHECK(bench.read(1, 99, 0, 50) == ErrorCode::kLogChanged);  // a refused read ends the old, too
  bench.run();
  CHECK(bench.frames == 1);
}
