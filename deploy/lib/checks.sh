# Checks of the source text, shared by test.sh and nightly.sh. Sourced after common.sh.

sources() { git -C "$root" ls-files '*.cc' '*.h'; }

# check_format: every C++ file as .clang-format says. Prints the command that corrects a file.
check_format() {
  cd "$root"
  local bad
  bad=$(sources | xargs -P "$(nproc)" -n 40 clang-format-14 --dry-run 2>&1 | sed -n 's/^\([^:]*\):[0-9]*:[0-9]*: warning: .*/\1/p' | sort -u)
  [ -z "$bad" ] && { echo "$(sources | wc -l) files: clean"; return; }
  echo "$bad"
  die "files above differ from .clang-format: clang-format-14 -i FILE"
}

# tidy_files PRESET SECONDS FILE...: clang-tidy until the time is spent. Sets tidy_left to the files not reached; fails on a finding.
tidy_files() {
  local preset=$1 limit=$2; shift 2
  local begun; begun=$(date +%s)
  tidy_left=()
  local pending=("$@") batch found=0
  while [ ${#pending[@]} -gt 0 ]; do
    if [ $(($(date +%s) - begun)) -ge "$limit" ]; then tidy_left=("${pending[@]}"); break; fi
    batch=("${pending[@]:0:$(nproc)}"); pending=("${pending[@]:${#batch[@]}}")
    printf '%s\n' "${batch[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy-14 -p "$root/build/$preset" --quiet --warnings-as-errors='*' 2>/dev/null || found=1
  done
  echo "clang-tidy: $(($# - ${#tidy_left[@]})) of $# files in $(($(date +%s) - begun)) s"
  return $found
}

# changed_sources: .cc files changed since the commit that the nightly run found clean (docs/evidence/tidy_clean_at), newest change first;
# all of them where that commit is unknown.
changed_sources() {
  cd "$root"
  local base; base=$(cat docs/evidence/tidy_clean_at 2>/dev/null || true)
  if [ -n "$base" ] && git cat-file -e "$base^{commit}" 2>/dev/null; then
    git log --format= --name-only "$base"..HEAD -- '*.cc' | awk 'NF && !seen[$0]++' | while read -r file; do [ -f "$file" ] && echo "$file"; done
  else
    git ls-files '*.cc'
  fi
}
