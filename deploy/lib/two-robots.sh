# Case C.2 of the published study: two robots that touch, indentation. Sourced by demo.sh.

default_speed=20

# control LINE: the simulated cell's private port, one answer without its OK
control() {
  local address answer
  address=$(sed -n 's/^READY .*"control": *"\([^"]*\)".*/\1/p' "$out/cellsim.out")
  exec 3<>"/dev/tcp/${address%:*}/${address##*:}"
  echo "$1" >&3
  read -r answer <&3
  exec 3>&-
  case "$answer" in OK*) echo "${answer#OK }" ;; *) die "control port, $1: $answer" ;; esac
}

# truth COLUMN: what really is, now
truth() { control 'truth?' | sed -n "s/.*\"$1\":\([^,}]*\).*/\1/p"; }

# microscope CONTACT: the craters from this contact on, as CSV
microscope() {
  echo 'id,x_um,y_um,pixel_nm,marking_px,pictures_joined,diagonal_um'
  control "microscope? $1" | sed 's/},{/\n/g; s/[][{}"]//g; s/[a-z_]*://g'
}

demo() {
  local zero status=0
  say "the simulated cell and the daemon, speed $speed, seed $seed"
  start_cell two-robots "$speed" "$seed" ${cellsim_options:-}
  cp "$cell/indentation.toml" "$cell/table_8_1.csv" "$out/"
  driftwise home
  say "indentation: touch, align, common zero, 10 indents (raw motor coordinates by geometry)"
  driftwise indent start indentation.toml 2>&1 | tee indentation.txt
  say "the microscope's table onto the indents"
  zero=$(sed -n 's/.*the first is contact \([0-9]*\)\..*/\1/p' indentation.txt)
  microscope "$zero" >microscope.csv
  driftwise indent import indentation.toml microscope.csv -o indents.csv || status=$?
  [ $status -le 1 ] || die "the import ended with exit code $status"
  driftwise indent import indentation.toml microscope.csv --json >indents.json || true
  say "the published table 8.1 through the same command"
  driftwise indent table table_8_1.csv --wanted 0.2 || true
  say "the truth of the simulated cell, which nothing above was told"
  cat <<TXT
tool lever             $(truth lever_mm | awk '{ printf "%.2f", $1 }') mm; stated 100
microscope scale       x +2 %, y +0.4 %
table                  $(sed -n 's/.*"indistinguishable":\(\[[^]]*\]\).*/\1/p' indents.json): the set named
TXT
  say "done. Everything is in $out"
  cat <<TXT
  indents.csv           the table;   microscope.csv  as the simulated microscope gave it
  indentation.toml.state.json  the record of the procedure;   truth.csv  where tool and substrate really were
  logs                  driftwised.log, cellsim.log
TXT
}
