#include "check.h"

int main() { return tfsat_test::run_all(); }
