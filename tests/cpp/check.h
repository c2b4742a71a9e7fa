// A test program's few needs: named cases, checks that go on after a failure, an exit code.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace tfsat_test {

struct Case {
  const char* name;
  void (*run)();
  Case* next;
  static Case*& first() {
    static Case* head = nullptr;
    return head;
  }
  Case(const char* case_name, void (*function)()) : name(case_name), run(function), next(first()) {
    first() = this;
  }
};

inline int& failures() {
  static int count = 0;
  return count;
}

// A loop that a defect keeps from ending must not fill the disk.
constexpr int kMostFailures = 200;

inline bool report(bool ok, const char* text, const char* file, int line) {
  if (ok) return true;
  ++failures();
  std::printf("%s:%d: failed: %s\n", file, line, text);
  if (failures() < kMostFailures) return false;
  std::printf("%d checks failed: ending here\n", failures());
  std::exit(1);
}

inline bool near(double a, double b, double tolerance, const char* text, const char* file,
                 int line) {
  const bool ok = std::fabs(a - b) <= tolerance;  // false for NaN
  if (!ok) std::printf("  %.12g against %.12g, tolerance %.3g\n", a, b, tolerance);
  return report(ok, text, file, line);
}

inline int run_all() {
  int cases = 0;
  for (Case* c = Case::first(); c != nullptr; c = c->next, ++cases) {
    const int before = failures();
    c->run();
    std::printf("%s %s\n", failures() == before ? "ok  " : "FAIL", c->name);
  }
  std::printf("%d cases, %d failed checks\n", cases, failures());
  return failures() == 0 && cases > 0 ? 0 : 1;
}

}  // namespace tfsat_test

#define TEST_CASE(name)                                               \
  static void name();                                                 \
  static const tfsat_test::Case name##_case(#name, name);             \
  static void name()
#define CHECK(condition) tfsat_test::report((condition), #condition, __FILE__, __LINE__)
#define CHECK_NEAR(a, b, tolerance) \
  tfsat_test::near((a), (b), (tolerance), #a " == " #b, __FILE__, __LINE__)
