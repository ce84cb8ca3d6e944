// Compiles bindings and databases into the decoder's tables, and reports every mismatch.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "base/nearest_name.hpp"
#include "can_protocol/decode/condition_compile.hpp"
#include "can_protocol/decode/decoder_tables.hpp"
#include "can_protocol/decode/name_hints.hpp"
#include "can_protocol/decode/units.hpp"

namespace odomd::can {
namespace {

/// A message and the first database that contains a message of this name.
struct Found {
  const Message* message = nullptr;
  const Database* database = nullptr;
};

class Compiler {
 public:
  Compiler(const DecoderInputs& inputs, Decoder::Tables& tables)
      : inputs_(inputs), tables_(tables) {}

  void run() {
    check_protections();
    for (const SignalBinding& binding : inputs_.bindings) group(binding);
    for (const Group& group : groups_) add_message(group);
    for (std::size_t i = 0; i < groups_.size(); ++i) add_identifier(i);
    std::ranges::sort(tables_.extended, std::ranges::greater{}, &MaskedEntries::mask);
    for (MaskedEntries& masked : tables_.extended)
      std::ranges::sort(masked.entries, {}, &ExtendedEntry::id);
    tables_.counters.resize(groups_.size());
    tables_.protections.resize(groups_.size());
  }

 private:
  struct Group {
    Found found;
    std::vector<const SignalBinding*> bindings;
  };

  // Looking up ------------------------------------------------------------------------------------

  [[nodiscard]] Found find(std::string_view name) const {
    for (const Database& database : inputs_.databases)
      if (const Message* message = find_message(database, name)) return {message, &database};
    return {};
  }

  /// Error text for a message that was not found: the databases, and a hint at the right name.
  template <typename Asked>
  [[nodiscard]] std::string missing(const std::string& name, const Asked& asked) const {
    if (inputs_.databases.empty()) return "there is no database in which to look up '" + name + "'";
    std::string files;
    for (const Database& database : inputs_.databases)
      files += (files.empty() ? "" : ", ") + database.file;
    return "no message '" + name + "' in " + files + message_hint(inputs_.databases, asked);
  }

  template <typename Hint>
  static const Signal& require_signal(const SignalBinding& binding, const Found& found,
                                      const std::string& name, const Hint& hint) {
    const Signal* signal = find_signal(*found.message, name);
    if (signal == nullptr)
      refuse(binding, "message '" + found.message->name + "' of " + found.database->file +
                          " has no signal '" + name + "'" + hint(name));
    return *signal;
  }

  void check_protections() const {
    for (std::size_t i = 0; i < inputs_.protections.size(); ++i) {
      const std::string& name = inputs_.protections[i].message;
      const Found found = find(name);
      if (found.message == nullptr)
        throw std::invalid_argument("end-to-end protection: " + missing(name, name));
      for (std::size_t j = 0; j < i; ++j)
        if (find(inputs_.protections[j].message).message == found.message)
          throw std::invalid_argument("end-to-end protection: message '" + name +
                                      "' is named twice; remove one");
      // Also checks messages without a binding, so that errors are found at start.
      (void)E2eProtection(*found.message, inputs_.protections[i]);
    }
  }

  void group(const SignalBinding& binding) {
    const Found found = find(binding.message);
    if (found.message == nullptr) refuse(binding, missing(binding.message, binding));
    auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& other) {
      return other.found.message == found.message;
    });
    if (group == groups_.end()) group = groups_.insert(groups_.end(), {found, {}});
    group->bindings.push_back(&binding);
  }

  // Compiling -------------------------------------------------------------------------------------

  void add_message(const Group& group) {
    const Message& message = *group.found.message;
    if (group.bindings.size() > max_samples_per_frame)
      refuse(*group.bindings.back(), "message '" + message.name + "' has more than " +
                                         std::to_string(max_samples_per_frame) +
                                         " bindings; remove some");
    CompiledMessage compiled;
    compiled.bindings = {size_of(tables_.bindings),
                         static_cast<std::uint32_t>(group.bindings.size())};
    // A control unit that was silent for longer than this has restarted.
    compiled.restart_ns = std::max<std::int64_t>(1'000'000'000, 3 * message.cycle_time_ns);
    BoundMessage bound{message.name,          message.id, message.format,
                       message.cycle_time_ns, {},         message.id_mask};
    for (const SignalBinding* binding : group.bindings) {
      const CompiledBinding& added =
          tables_.bindings.emplace_back(compile_binding(*binding, group.found));
      compiled.bus_mask |= added.bus_mask;
      if (added.source)
        compiled.sources.set(*added.source);
      else
        compiled.sources.set();
      bound.channels.push_back(binding->channel);
    }
    for (const E2eBinding& protection : inputs_.protections)
      if (find(protection.message).message == &message && protection.profile != E2eProfile::none)
        compiled.protection.emplace(message, protection);
    tables_.messages.push_back(compiled);
    tables_.bound.push_back(std::move(bound));
  }

  /// The table entry for the first message with this (masked) identifier.
  std::int16_t& first_place(const Message& message) {
    if (message.format == IdFormat::standard) return tables_.standard[message.id];
    auto masked = std::ranges::find(tables_.extended, message.id_mask, &MaskedEntries::mask);
    if (masked == tables_.extended.end())
      masked = tables_.extended.insert(masked, {message.id_mask, {}});
    const std::uint32_t id = message.id & message.id_mask;
    const auto entry = std::ranges::find(masked->entries, id, &ExtendedEntry::id);
    return entry != masked->entries.end()
               ? entry->message
               : masked->entries.emplace_back(ExtendedEntry{id, -1}).message;
  }

  /// Chains messages with the same identifier; their buses or sources must differ.
  void add_identifier(std::size_t index) {
    const Message& message = *groups_[index].found.message;
    CompiledMessage& compiled = tables_.messages[index];
    std::int16_t* const first = &first_place(message);
    for (std::int16_t at = *first; at >= 0;) {
      const auto other = static_cast<std::size_t>(at);
      if ((tables_.messages[other].bus_mask & compiled.bus_mask) != 0 &&
          (tables_.messages[other].sources & compiled.sources).any())
        refuse(*groups_[index].bindings.front(),
               "message '" + message.name + "' has the identifier of message '" +
                   tables_.bound[other].name +
                   "', which is bound as well; give their signals different buses" +
                   (message.id_mask == whole_id ? "" : " or sources"));
      at = tables_.messages[other].next;
    }
    compiled.next = *first;
    *first = static_cast<std::int16_t>(index);
  }

  CompiledBinding compile_binding(const SignalBinding& binding, const Found& found) {
    CompiledBinding compiled;
    compiled.channel = binding.channel;
    compiled.latency_ns = binding.latency_ns;
    compiled.bus_mask = bus_mask(binding);
    compiled.source = source(binding, found);
    compiled.scale = binding.scale;
    compiled.offset = binding.offset;
    if (!std::isfinite(binding.scale) || !std::isfinite(binding.offset))
      refuse(binding, "scale or offset is not a finite number; fix it");

    const bool direction = binding.forward || binding.reverse;
    if (binding.signals.empty()) refuse(binding, "no signal is named; add one");
    if (direction && binding.signals.size() > 1)
      refuse(binding, "a direction comes from one signal, not from a sum; name one");
    std::vector<const Signal*> read;  // all signals that must be present
    for (const std::string& name : binding.signals)
      read.push_back(&require_signal(binding, found, name, [&](const std::string& absent) {
        return signal_hint(inputs_.databases, *found.message, binding, absent);
      }));
    compiled.terms = {size_of(tables_.terms), static_cast<std::uint32_t>(read.size())};
    for (const Signal* signal : read) tables_.terms.push_back(layout_of(*signal));
    if (direction) {
      if (binding.forward) compiled.forward = compile_match(binding, *read[0], *binding.forward);
      if (binding.reverse) compiled.reverse = compile_match(binding, *read[0], *binding.reverse);
      if (compiled.forward && compiled.reverse && compiled.forward->bits == compiled.reverse->bits)
        refuse(binding, "forward and reverse are the same value; fix one");
    } else {
      for (const Signal* signal : read) {
        check_unit(binding, found, *signal);
        if (signal->scale == 0.0)
          refuse(binding, "signal '" + signal->name + "' has the factor 0 in " +
                              found.database->file + ':' + std::to_string(signal->line) +
                              " and never changes; fix the database");
      }
      compiled.unit_factor = unit_factor(binding);
    }
    compiled.conditions.first = size_of(tables_.conditions);
    for (const Signal* signal : read) add_unless_raw(binding, *signal, tables_.conditions);
    const auto read_other = [&](const std::string& name) -> const Signal& {
      return *read.emplace_back(&require_signal(binding, found, name, [&](const auto& absent) {
        return nearest_signal_hint(*found.message, absent);
      }));
    };
    for (const ValidWhen& condition : binding.valid_when)
      tables_.conditions.push_back(
          compile_condition(binding, read_other(condition.signal), condition));
    compiled.conditions.count = size_of(tables_.conditions) - compiled.conditions.first;
    if (binding.sign)
      compiled.negative =
          compile_match(binding, read_other(binding.sign->signal), binding.sign->negative);
    compiled.doubts_first_ends = !binding.unless_raw && !direction;
    for (const Signal* signal : read)
      compiled.bytes_needed = std::max(compiled.bytes_needed, layout_of(*signal).bytes_needed);
    compiled.selectors.first = size_of(tables_.selectors);
    for (const Signal* signal : read) add_selectors(*found.message, *signal);
    compiled.selectors.count = size_of(tables_.selectors) - compiled.selectors.first;
    return compiled;
  }

  [[nodiscard]] std::uint8_t bus_mask(const SignalBinding& binding) const {
    if (binding.bus.empty()) return 0xFF;
    const auto found = std::find(inputs_.bus_names.begin(), inputs_.bus_names.end(), binding.bus);
    if (found == inputs_.bus_names.end() ||
        found - inputs_.bus_names.begin() >= static_cast<std::ptrdiff_t>(max_buses))
      refuse(binding, "there is no bus '" + binding.bus + "'" +
                          nearest_hint(binding.bus, inputs_.bus_names));
    return static_cast<std::uint8_t>(1U << (found - inputs_.bus_names.begin()));
  }

  static std::optional<std::uint8_t> source(const SignalBinding& binding, const Found& found) {
    const Message& message = *found.message;
    if (binding.source &&
        (message.id_mask == whole_id ||
         ((message.id_mask & 0xFFU) != 0 && *binding.source != (message.id & 0xFFU))))
      refuse(binding, "source " + std::to_string(*binding.source) +
                          " chooses a sender of a J1939 group, but message '" + message.name +
                          "' of " + found.database->file + ':' + std::to_string(message.line) +
                          " has one identifier only; leave source out");
    return binding.source;
  }

  static void check_unit(const SignalBinding& binding, const Found& found, const Signal& signal) {
    if (binding.unit == Unit::none) return;
    const auto stated = unit_of_text(signal.unit);
    const bool contradicts = stated ? *stated != binding.unit : is_other_unit(signal.unit);
    if (!contradicts) return;
    refuse(binding, "unit '" + std::string(unit_name(binding.unit)) + "' contradicts '" +
                        signal.unit + "' of signal '" + found.message->name + '.' + signal.name +
                        "' in " + found.database->file + ':' + std::to_string(signal.line) +
                        (stated ? "; fix one of them"
                                : "; fix one of them, or use unit = \"1\" with a scale"));
  }

  /// Factor to SI; with a radius, to the speed of the wheel, v = omega * radius / ratio.
  static double unit_factor(const SignalBinding& binding) {
    const double factor = si_factor(binding.unit);
    if (!is_rotation(binding.unit) || (binding.radius_m == 0.0 && !is_revolutions(binding.unit)))
      return factor;
    if (!(binding.radius_m > 0.0) || !std::isfinite(binding.radius_m))
      refuse(binding, "unit " + std::string(unit_name(binding.unit)) +
                          " needs the wheel's radius in metres; add a positive radius");
    if (binding.ratio == 0.0 || !std::isfinite(binding.ratio))
      refuse(binding, "the ratio must be a number other than 0; fix it");
    return factor * binding.radius_m / binding.ratio;
  }

  void add_selectors(const Message& message, const Signal& signal) {
    for (const Signal* at = &signal; at->multiplexor; at = &message.signals[*at->multiplexor]) {
      tables_.selectors.push_back(
          {layout_of(message.signals[*at->multiplexor]),
           {size_of(tables_.ranges), static_cast<std::uint32_t>(at->selected_by.size())}});
      tables_.ranges.insert(tables_.ranges.end(), at->selected_by.begin(), at->selected_by.end());
    }
  }

  template <typename T>
  static std::uint32_t size_of(const std::vector<T>& items) {
    return static_cast<std::uint32_t>(items.size());
  }

  const DecoderInputs& inputs_;
  Decoder::Tables& tables_;
  std::vector<Group> groups_;
};

}  // namespace

void compile(const DecoderInputs& inputs, Decoder::Tables& tables) {
  Compiler(inputs, tables).run();
}

}  // namespace odomd::can
