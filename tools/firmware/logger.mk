# Builds the logger's core, drivers and sketch for the Teensy 4.1 (Cortex-M7):
#   make -f tools/firmware/logger.mk BUILD=build/logger
# Against the stub headers of tests/teensy_logger/stubs, because no package has the Teensy core: the ELF proves
# that all of it compiles without a warning, links whole and fits, with no heap and no exceptions. The
# image to flash is made by the Arduino IDE (Teensyduino 1.59 or later) from the same sketch folder.
SKETCH ?= firmware/teensy_logger
BUILD ?= build/logger
STUBS ?= tests/teensy_logger/stubs

NAME := $(notdir $(abspath $(SKETCH)))
CXX := arm-none-eabi-g++
NM := arm-none-eabi-nm
SIZE := arm-none-eabi-size

define missing
$(error $(1) is missing: the logger's firmware cannot be built. Run tools/install-toolchain.sh)
endef
$(foreach tool,$(CXX) $(NM) $(SIZE),$(if $(shell command -v $(tool)),,$(call missing,$(tool))))
$(if $(wildcard $(SKETCH)/$(NAME).ino),,$(error there is no sketch $(SKETCH)/$(NAME).ino))

CPU := -mthumb -mcpu=cortex-m7 -mfloat-abi=hard -mfpu=fpv5-d16
BOARD := -D__IMXRT1062__ -DTEENSYDUINO=159 -DARDUINO=10813 -DARDUINO_TEENSY41 -DF_CPU=600000000 \
  -DUSB_SERIAL -DLAYOUT_US_ENGLISH
CXX_FLAGS := $(CPU) $(BOARD) -O2 -ffunction-sections -fdata-sections -std=gnu++17 -fno-exceptions \
  -fno-rtti -fno-threadsafe-statics -fno-use-cxa-atexit -Wall -Wextra -Werror -MMD -I$(STUBS)
LINK_FLAGS := $(CPU) -O2 -nostartfiles --specs=nano.specs --specs=nosys.specs -Wl,--gc-sections \
  -T $(STUBS)/teensy41.ld

SOURCES := $(sort $(shell find $(SKETCH)/src -name '*.cpp'))
OBJECTS := $(patsubst $(SKETCH)/%,$(BUILD)/%.o,$(SOURCES)) $(BUILD)/$(NAME).ino.o $(BUILD)/stubs.o
ELF := $(BUILD)/$(NAME).elf

# The heap, exceptions and guarded statics, whatever pulls them in.
FORBIDDEN := ' (_Znwj|_Znaj|_ZdlPv|_ZdaPv|_?malloc(_r)?|_sbrk|__cxa_throw|__cxa_guard_acquire)$$'

.PHONY: all
all: $(ELF)
	@$(SIZE) -A -d $(ELF) | awk '/^\.(text|data|bss|progmem|dmabuffers)/ {print $$1, $$2}'

$(BUILD)/%.cpp.o: $(SKETCH)/%.cpp
	@mkdir -p $(@D)
	@$(CXX) $(CXX_FLAGS) -c $< -o $@

# As the Arduino IDE does: the sketch is C++ with Arduino.h before it.
$(BUILD)/$(NAME).ino.o: $(SKETCH)/$(NAME).ino
	@mkdir -p $(@D)
	@$(CXX) $(CXX_FLAGS) -x c++ -include Arduino.h -c $< -o $@

$(BUILD)/stubs.o: $(STUBS)/stubs.cpp
	@mkdir -p $(@D)
	@$(CXX) $(CXX_FLAGS) -c $< -o $@

$(ELF): $(OBJECTS) $(STUBS)/teensy41.ld
	@$(CXX) $(LINK_FLAGS) $(OBJECTS) -o $@.part
	@if $(NM) $@.part | grep -E $(FORBIDDEN); then \
	  echo "$@: the firmware must not use the heap, exceptions or guarded statics" >&2; exit 1; fi
	@mv $@.part $@

# A header that was moved or deleted: what included it is compiled again.
%.h: ;

-include $(OBJECTS:.o=.d)
