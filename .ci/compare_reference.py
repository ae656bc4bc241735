#!/usr/bin/env python3
"""Compare our decoding of an ASTERIX recording with that of a reference decoder (libasterix), value by value.

usage: compare_reference.py REFERENCE.jsonl OURS.jsonl

Both files hold one JSON object a line: item number -> value, "_c" = category, "_ts" = capture time in s where there is
one.  OURS comes from `koseki decode`.  Records are paired in order; numbers may differ by 1e-9 of their size, capture
times by a microsecond.  What is known to differ, and why, is listed in KNOWN below: it is checked as well, against what
the difference must be, and counted.
Exit status 1 on any other difference.
"""
import json
import sys

UNDEFINED = '\ufffd'                    # ours, for a code that stands for no character
UNKNOWN_EXTENSION = '_unknown_extension'
TOLERANCE = 1e-9
TIME_STAMP_TOLERANCE_S = 1e-6


def quadruple(ours, reference, group):
    return near(ours, 4 * reference)


def unsigned_4_bits(ours, reference, group):
    return near(ours, reference % 16)


def signed_level(ours, reference, group):
    return near(ours, reference if reference < 2048 else reference - 4096)


def air_speed(ours, reference, group):
    return near(ours, reference * (0.001 if group['IM'] else 2 ** -14))


# (category, path): (how ours follows from the reference's value, why)
KNOWN = {
    (10, '202/VX'): (quadruple, 'LSB is 2^-2 m/s: I010/200, positions and CAT020 agree; the definition says 2^-4'),
    (10, '202/VY'): (quadruple, 'LSB is 2^-2 m/s: I010/200, positions and CAT020 agree; the definition says 2^-4'),
    (10, '210/AX'): (quadruple, 'LSB is 2^-2 m/s2: changes of velocity agree; the definition says 2^-4'),
    (10, '210/AY'): (quadruple, 'LSB is 2^-2 m/s2: changes of velocity agree; the definition says 2^-4'),
    (21, '090/PA'): (unsigned_4_bits, 'a category from 0 to 9, which the definition has signed'),
    (21, '150/AS'): (air_speed, 'the reference gives the number sent where the LSB depends on another element'),
    (48, '090/FL'): (signed_level, "two's complement as in edition 1.32; the definitions before it state no sign"),
    (62, '380/IAS/IAS'): (air_speed, 'the reference gives the number sent where the LSB depends on another element'),
}
UNDEFINED_CHARACTER = 'the reference leaves out or passes on codes without a character, ours shows them'
REFUSED_EXTENSION = 'the reference refuses a block with an item that goes on beyond its edition'


def near(a, b):
    return abs(a - b) <= TOLERANCE * max(abs(a), abs(b))


def is_number(x):
    return isinstance(x, (int, float)) and not isinstance(x, bool)


def undefined_characters(ours, reference):
    """Six-bit codes are left out, eight-bit codes become control and other characters."""
    if len(ours) != len(reference):
        return ours.replace(UNDEFINED, '') == reference
    return all(a == b or a == UNDEFINED and not ' ' <= b <= '~' for a, b in zip(ours, reference))


class Comparison:
    def __init__(self):
        self.records = self.values = 0
        self.known = {}                 # (category, path, reason) -> count
        self.unexplained = []

    def note(self, category, path, reason):
        key = category, path, reason
        self.known[key] = self.known.get(key, 0) + 1

    def fail(self, line, path, ours, reference):
        self.unexplained.append(f'record {line}, {path or "record"}: ours {ours!r}, reference {reference!r}')

    def record(self, line, ours, reference):
        self.records += 1
        self.node(line, ours.get('_c'), '', ours, reference, None)

    def node(self, line, category, path, ours, reference, group):
        """Descend both trees; list positions are no part of the path."""
        if isinstance(ours, dict) and isinstance(reference, dict) and ours.keys() == reference.keys():
            for key in ours:
                self.node(line, category, f'{path}/{key}'.lstrip('/'), ours[key], reference[key], ours)
        elif isinstance(ours, list) and isinstance(reference, list) and len(ours) == len(reference):
            for a, b in zip(ours, reference):
                self.node(line, category, path, a, b, group)
        elif isinstance(ours, (dict, list)) or isinstance(reference, (dict, list)):
            self.fail(line, path, ours, reference)
        else:
            self.values += 1
            self.leaf(line, category, path, ours, reference, group)

    def leaf(self, line, category, path, ours, reference, group):
        if path == '_ts':
            if abs(ours - reference) > TIME_STAMP_TOLERANCE_S:
                self.fail(line, path, ours, reference)
        elif is_number(ours) and is_number(reference):
            rule = KNOWN.get((category, path))
            if rule:
                if not rule[0](ours, reference, group):
                    self.fail(line, path, ours, reference)
                elif not near(ours, reference):
                    self.note(category, path, rule[1])
            elif not near(ours, reference):
                self.fail(line, path, ours, reference)
        elif ours != reference:
            if isinstance(ours, str) and UNDEFINED in ours and undefined_characters(ours, reference):
                self.note(category, path, UNDEFINED_CHARACTER)
            else:
                self.fail(line, path, ours, reference)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    comparison = Comparison()
    with open(sys.argv[1]) as reference_file, open(sys.argv[2]) as our_file:
        reference_lines = iter(reference_file)
        for line, text in enumerate(our_file, 1):
            ours = json.loads(text)
            beyond = [item for item, value in ours.items() if isinstance(value, dict) and UNKNOWN_EXTENSION in value]
            if beyond:
                comparison.note(ours['_c'], beyond[0], REFUSED_EXTENSION)
                continue
            reference = next(reference_lines, None)
            if reference is None:
                comparison.fail(line, '', ours, None)
                break
            comparison.record(line, ours, json.loads(reference))
        left_over = sum(1 for _ in reference_lines)
    if left_over:
        comparison.unexplained.append(f'{left_over} records of the reference have none of ours')

    print(f'{comparison.records} records, {comparison.values} values compared')
    for (category, path, reason), count in sorted(comparison.known.items()):
        print(f'{count:>9} known: I{category:03}/{path}: {reason}')
    print(f'{len(comparison.unexplained):>9} unexplained')
    for difference in comparison.unexplained[:20]:
        print('  ' + difference)
    sys.exit(1 if comparison.unexplained else 0)


main()
