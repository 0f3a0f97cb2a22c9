#pragma once

namespace CLI {
class App;
}

namespace trunnion {

/// Gives `program` a help that can be read aloud: beside an option what it takes ("NUMBER", "{on,off}"), after what it
/// does the bounds, the default, and what it goes with or shuts out. Commands added later take it over.
void set_help_format(CLI::App& program);

}  // namespace trunnion
