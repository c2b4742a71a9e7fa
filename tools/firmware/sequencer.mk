# Builds a sketch folder for the Arduino Micro (ATmega32U4, 16 MHz) as the Arduino IDE does:
#   make -f tools/firmware/sequencer.mk BUILD=build/sequencer
# Result: $(BUILD)/$(NAME).hex, .elf and .json (flash, RAM, image CRC). The same sources give the same
# bytes wherever and whenever they are built. SKETCH names another sketch folder.
SKETCH ?= firmware/arduino_sequencer
BUILD ?= build/sequencer
ARDUINO_AVR ?= /usr/share/arduino/hardware/arduino/avr
PYTHON ?= python3

NAME := $(notdir $(abspath $(SKETCH)))
HERE := $(dir $(lastword $(MAKEFILE_LIST)))
CORE := $(ARDUINO_AVR)/cores/arduino
VARIANT := $(ARDUINO_AVR)/variants/micro

define missing
$(error $(1) is missing: the sequencer's firmware cannot be built. Run tools/install-toolchain.sh)
endef
$(foreach tool,avr-gcc avr-g++ avr-gcc-ar avr-objcopy,$(if $(shell command -v $(tool)),,$(call missing,$(tool))))
$(if $(wildcard $(CORE)/Arduino.h),,$(call missing,the Arduino core ($(CORE))))
$(if $(wildcard $(SKETCH)/$(NAME).ino),,$(error there is no sketch $(SKETCH)/$(NAME).ino))

# Boards.txt "micro" and platform.txt of the Arduino core. DECIMAL_DIG is for its WString.cpp.
BOARD := -mmcu=atmega32u4 -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_MICRO -DARDUINO_ARCH_AVR \
  -DUSB_VID=0x2341 -DUSB_PID=0x8037 '-DUSB_PRODUCT="Arduino Micro"' -DDECIMAL_DIG=__DECIMAL_DIG__ \
  -I$(CORE) -I$(VARIANT)
COMMON := -Os -flto -fno-fat-lto-objects -ffunction-sections -fdata-sections -MMD -MP
C_FLAGS := $(COMMON) -std=gnu11
CPP_FLAGS := $(COMMON) -std=gnu++11 -fno-exceptions -fno-threadsafe-statics
SKETCH_WARNINGS := -Wall -Wextra -Werror

CORE_SOURCES := $(sort $(wildcard $(CORE)/*.c $(CORE)/*.cpp $(CORE)/*.S))
CORE_OBJECTS := $(patsubst $(CORE)/%,$(BUILD)/core/%.o,$(CORE_SOURCES))
SKETCH_SOURCES := $(sort $(shell find $(SKETCH)/src -name '*.cpp' -o -name '*.c' 2>/dev/null))
SKETCH_OBJECTS := $(patsubst $(SKETCH)/%,$(BUILD)/sketch/%.o,$(SKETCH_SOURCES)) $(BUILD)/sketch/$(NAME).ino.cpp.o

.PHONY: all
all: $(BUILD)/$(NAME).json

$(BUILD)/core/%.c.o: $(CORE)/%.c
	@mkdir -p $(@D)
	@avr-gcc $(BOARD) $(C_FLAGS) -w -c $< -o $@

$(BUILD)/core/%.cpp.o: $(CORE)/%.cpp
	@mkdir -p $(@D)
	@avr-g++ $(BOARD) $(CPP_FLAGS) -fpermissive -w -c $< -o $@

$(BUILD)/core/%.S.o: $(CORE)/%.S
	@mkdir -p $(@D)
	@avr-gcc $(BOARD) $(COMMON) -x assembler-with-cpp -c $< -o $@

$(BUILD)/core.a: $(CORE_OBJECTS)
	@rm -f $@
	@avr-gcc-ar rcsD $@ $^

$(BUILD)/sketch/%.c.o: $(SKETCH)/%.c
	@mkdir -p $(@D)
	@avr-gcc $(BOARD) $(C_FLAGS) $(SKETCH_WARNINGS) -c $< -o $@

$(BUILD)/sketch/%.cpp.o: $(SKETCH)/%.cpp
	@mkdir -p $(@D)
	@avr-g++ $(BOARD) $(CPP_FLAGS) $(SKETCH_WARNINGS) -c $< -o $@

$(BUILD)/sketch/$(NAME).ino.cpp: $(SKETCH)/$(NAME).ino
	@mkdir -p $(@D)
	@{ printf '#include <Arduino.h>\n#line 1 "%s"\n' '$(NAME).ino'; cat $<; } > $@

$(BUILD)/sketch/$(NAME).ino.cpp.o: $(BUILD)/sketch/$(NAME).ino.cpp
	@avr-g++ $(BOARD) -I$(SKETCH) $(CPP_FLAGS) $(SKETCH_WARNINGS) -c $< -o $@

# Sources are linked in sorted order, so that a renamed folder does not change the image.
$(BUILD)/$(NAME).elf: $(SKETCH_OBJECTS) $(BUILD)/core.a
	@avr-gcc -mmcu=atmega32u4 -Os -flto -fuse-linker-plugin -Wl,--gc-sections -w $^ -lm -o $@

$(BUILD)/$(NAME).hex: $(BUILD)/$(NAME).elf
	@avr-objcopy -O ihex -R .eeprom $< $@

$(BUILD)/$(NAME).json: $(BUILD)/$(NAME).hex $(BUILD)/$(NAME).elf $(HERE)image_report.py
	@$(PYTHON) $(HERE)image_report.py $(BUILD)/$(NAME).hex $(BUILD)/$(NAME).elf $@

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
