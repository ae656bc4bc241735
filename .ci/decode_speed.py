#!/usr/bin/env python3
"""Time of koseki.decode against that of a reference decoder (libasterix), on the same records in one run.

usage: decode_speed.py FILE.ast CATEGORY=EDITION ...

The reference takes every so many'th block of a raw file, so that it is done in some seconds, and makes a dict of each
record; ours takes all.  Figures are records a second, the best of three for ours.
"""
import sys
import time

import asterix.generated as generated
from asterix import base

import koseki
from random_records import value

BLOCKS = 2000


def blocks(octets):
    at = 0
    while at < len(octets):
        length = int.from_bytes(octets[at + 1:at + 3], 'big')
        yield octets[at:at + length]
        at += length


def reference(chosen, uaps):
    records = 0
    for block in chosen:
        rest = base.Bits.from_bytes(block[3:])
        while len(rest):
            parsed, rest = uaps[block[0]].parse(base.ParsingMode.PartialParsing, rest)
            {name: value(item.arg.arg) for name, item in parsed.items_regular.items()}
            records += 1
    return records


def rate(work):
    begin = time.perf_counter()
    records = work()
    return records / (time.perf_counter() - begin)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    path, editions = sys.argv[1], dict(word.split('=') for word in sys.argv[2:])
    uaps = {int(category): getattr(generated, f'Cat_{int(category):03}_{edition.replace(".", "_")}').cv_uap.cv_record
            for category, edition in editions.items()}
    with open(path, 'rb') as file:
        every = [block for block in blocks(file.read()) if block[0] in uaps]
    of_reference = rate(lambda: reference(every[::max(1, len(every) // BLOCKS)], uaps))
    dicts = max(rate(lambda: sum(1 for _ in koseki.decode(path, editions=editions))) for _ in range(3))
    columns = max(rate(lambda: sum(len(next(iter(table.values())))
                                   for table in koseki.decode_columns(path, editions=editions).values()))
                  for _ in range(3))
    print(f'{path}: libasterix {of_reference:,.0f} records/s, koseki dicts {dicts:,.0f} (x {dicts / of_reference:.0f}), '
          f'columns {columns:,.0f} (x {columns / of_reference:.0f})')


if __name__ == '__main__':
    main()
