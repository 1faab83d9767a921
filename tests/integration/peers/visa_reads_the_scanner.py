#!/usr/bin/python3
"""python3-pyvisa, which knows nothing of Driftwise, reads ten probes through the emulated scanner: TCP and serial line."""
import sys

from cellsim_process import SKIPPED, Cellsim, check

try:
    import pyvisa
except ImportError:
    print("python3-pyvisa and python3-pyvisa-py are not installed")
    sys.exit(SKIPPED)

LIST = "(@101:110)"
SET_UP = ["*RST", "*CLS", "TRAC:CLE", "INIT:CONT OFF", "FORM:ELEM READ,CHAN,TST", "TRIG:SOUR IMM", "TRIG:COUN 1",
          "TRIG:DEL 0", "FUNC 'FRES'," + LIST, "FRES:RANG 1000," + LIST, "FRES:OCOM ON," + LIST,
          "FRES:NPLC 5," + LIST, "SAMP:COUN 10", "ROUT:SCAN " + LIST, "ROUT:SCAN:TSO IMM", "ROUT:SCAN:LSEL INT"]


def scan(scanner):
    for command in SET_UP:
        scanner.write(command)
    check(scanner.query("*OPC?").strip() == "1", "the set-up is complete")
    check(scanner.query("SYST:ERR?").strip() == '0,"No error"', "without an error")
    check(scanner.query("ROUT:SCAN?").strip() == LIST, "the scan list stands as typed")
    fields = scanner.query("READ?").strip().split(",")
    check(len(fields) == 30, "ten readings of three elements, found %d fields" % len(fields))
    ohms, stamps, channels = fields[0::3], fields[1::3], fields[2::3]
    check(channels == [str(c) for c in range(101, 111)], "channels in order")
    check(all(1050 < float(ohm) < 1110 for ohm in ohms), "pt1000 between 13 and 28 degC: " + ohms[0])
    steps = [float(b) - float(a) for a, b in zip(stamps, stamps[1:])]
    check(all(abs(step - 0.43) < 0.002 for step in steps), "0.43 s of cell time per channel: %s" % steps[:3])
    check(scanner.query("FETC?").strip().split(",") == fields, "FETCh? repeats the scan")
    scanner.write("READING?")
    check(scanner.query("SYST:ERR?").startswith("-113"), "an unknown header is -113")


def main():
    manager = pyvisa.ResourceManager("@py")
    with Cellsim("emulator.scanner.serial=true") as cell:
        tcp = manager.open_resource("TCPIP0::127.0.0.1::%d::SOCKET" % cell.port("scanner"),
                                    read_termination="\n", write_termination="\n", timeout=10000)
        check(tcp.query("*IDN?").startswith("KEITHLEY INSTRUMENTS INC.,MODEL 2701"), "identifies over TCP")
        check(tcp.query("*OPT?").strip() == "7700,NONE", "names its cards")
        scan(tcp)
        tcp.close()
        try:
            serial = manager.open_resource("ASRL%s::INSTR" % cell.address["scanner-serial"], baud_rate=19200,
                                           read_termination="\r", write_termination="\r", timeout=10000)
        except ValueError as missing:  # pyvisa-py without python3-serial
            print("the serial line is not tried:", missing)
            return
        check(serial.query("*IDN?").startswith("KEITHLEY"), "identifies over the serial line")
        scan(serial)
        serial.close()


main()
