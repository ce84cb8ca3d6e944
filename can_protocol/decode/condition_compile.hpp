// Compiles the conditions under which a value is valid. Internal to the decoder.
#pragma once

#include <string>
#include <vector>

#include "can_protocol/decode/decoder_tables.hpp"

namespace odomd::can {

/// Throws std::invalid_argument, naming the role. The other functions here throw it, too.
[[noreturn]] void refuse(const SignalBinding& binding, const std::string& text);

/// The signal's bits at a physical value; refuses a value that the signal cannot have.
[[nodiscard]] CompiledMatch compile_match(const SignalBinding& binding, const Signal& signal,
                                          double value);

[[nodiscard]] CompiledCondition compile_condition(const SignalBinding& binding,
                                                  const Signal& signal, const ValidWhen& condition);

/// Appends one condition per raw value of unless_raw: the signal must not have this value.
void add_unless_raw(const SignalBinding& binding, const Signal& signal,
                    std::vector<CompiledCondition>& conditions);

}  // namespace odomd::can
