#!/bin/sh
# no_fixed_numbers.sh NM LIBRARY...: std::to_string of a double writes 0.000000 where 1e-9 is meant, so that no room may call
# it. Its helper __to_xstring stands as a symbol in every object that does.
nm=$1; shift
bad=0
for library in "$@"; do
  found=$("$nm" -A "$library" 2>/dev/null | grep __to_xstring | cut -d: -f1,2 | sort -u)
  [ -z "$found" ] || { echo "std::to_string of a double in: $found"; bad=1; }
done
[ $# -gt 20 ] || { echo "found $# libraries, expected those of all rooms"; bad=1; }
exit $bad
