#!/usr/bin/env python3
"""Random well-formed records of every edition that a reference decoder (libasterix) defines, and how it decodes them.

usage: [RECORDS=2000] random_records.py FOLDER CATEGORY ...

For each edition of these categories two files are written, named after both as in 048=1.31: .ast, with one record in
each block, and .reference, with one JSON object a line as compare_reference.py takes them.  Each edition of coding
rules for a reserved expansion field is tried with its category's newest edition, as in 048=1.32,048~RE=1.13.  Every
run writes the same.
"""
import json
import os
import random
import re
import sys

import asterix.generated as generated
from asterix import base

RECORDS = int(os.environ.get('RECORDS', 150))    # of each edition
DICE = random.Random(4)
CHANCES = 0.2, 0.5, 0.9                 # of an item to be in a record


def bits(count):
    return [DICE.getrandbits(1) for _ in range(count)]


def octet(number):
    return [number >> i & 1 for i in range(7, -1, -1)]


def make(variation):
    """Bits of an item's layout, spare bits and all."""
    if issubclass(variation, base.Element):
        return bits(variation.cv_bit_size)
    if issubclass(variation, base.Group):
        return sum((make_part(part) for part, _ in variation.cv_items_list), [])
    if issubclass(variation, base.Extended):
        parts = variation.cv_items_list[:DICE.randint(1, len(variation.cv_items_list))]
        return sum(([int(part is not parts[-1])] if piece is None else make_part(piece[0])
                    for part in parts for piece in part), [])
    if issubclass(variation, base.Repetitive):
        by_fx = variation.cv_rep_bytes is None
        count = DICE.randint(1 if by_fx else 0, 3)
        values = [make(variation.cv_variation) + ([int(i + 1 < count)] if by_fx else []) for i in range(count)]
        return sum(values, [] if by_fx else octet(count))
    if issubclass(variation, base.Explicit):
        length = DICE.randint(1, 8)
        return octet(length) + bits(8 * (length - 1))
    flags, items = announce(variation.cv_items_list)
    return fspec(flags) + sum(map(make_item, items), [])


def make_part(part):
    return bits(part.cv_bit_size) if issubclass(part, base.Spare) else make_item(part.cv_non_spare)


def make_item(item):
    """Bits of an item; of one whose parts depend on another item (I004/120/CC/CPC), those of the number it is."""
    rule = item.cv_rule
    dependent = issubclass(rule, base.RuleVariationDependent)
    return make(rule.cv_default_variation if dependent else rule.cv_variation)


def announce(items, always=()):
    chance = DICE.choice(CHANCES)
    flags = [item is not None and (item.cv_name in always or DICE.random() < chance) for item in items]
    return flags, [item for item, flag in zip(items, flags) if flag]


def fspec(flags):
    while flags and not flags[-1]:
        flags = flags[:-1]
    sevens = [flags[i:i + 7] for i in range(0, len(flags), 7)] or [[]]
    return sum(([int(flag) for flag in seven] + [0] * (7 - len(seven)) + [int(seven is not sevens[-1])]
                for seven in sevens), [])


def octets(sent):
    assert len(sent) % 8 == 0
    return bytes(int(''.join(map(str, sent[i:i + 8])), 2) for i in range(0, len(sent), 8))


def record(profile, decider, expansion):
    """A record, and what the reference makes of it. `decider` is the item and value that choose a profile."""
    entries = profile.cv_items_list
    items = [getattr(entry, 'cv_non_spare', None) for entry in entries]
    regular = [i for i, item in enumerate(items) if item is not None]
    flags, present = announce(items, always=[decider[0]] if decider else [])
    if not present:
        flags[0], present = True, [items[0]]
    body = []
    for item in present:
        sent = make_item(item)
        if decider and item.cv_name == decider[0]:
            sent[0] = decider[1]        # the only one published is a single bit, the first
        if expansion and item.cv_name == 'RE':
            announced, subitems = announce(list(expansion.cv_items_list))
            content = [int(flag) for flag in announced + [False] * 8][:8] + sum(map(make_item, subitems), [])
            sent = octet(len(content) // 8 + 1) + content if len(content) < 8 * 255 else octet(2) + octet(0)
        body += sent
    sequence = [i for i, entry in enumerate(entries) if issubclass(entry, base.UapItemRFS)]
    if sequence and not any(flags[sequence[0]:]):
        flags[sequence[0]] = True
        chosen = [DICE.choice(regular) for _ in range(DICE.randint(0, 3))]
        body += octet(len(chosen)) + sum((octet(i + 1) + make_item(items[i]) for i in chosen), [])
    sent = octets(fspec(flags) + body)
    parsed, rest = profile.parse(base.ParsingMode.StrictParsing, base.Bits.from_bytes(sent))
    assert not len(rest)
    values = {name: value_of(item) for name, item in parsed.items_regular.items()}
    for sequence in parsed.items_rfs:
        values['RFS'] = [{name: value_of(item)} for name, item in sequence]
    if expansion and 'RE' in values:
        content, _ = expansion._parse(base.Bits.from_bytes(bytes.fromhex(values['RE'])))
        values['RE'] = {name: value_of(item) for name, item in content.arg.items()}
    return sent, values


def value_of(item):
    rule = item.arg
    return value(rule._variation(None) if isinstance(rule, base.RuleVariationDependent) else rule.arg)


def value(variation):
    if isinstance(variation, base.Element):
        rule = variation._get_rule()
        if not isinstance(rule, base.RuleContentContextFree):
            return rule.as_uint()
        content = rule._get_content()
        for kind, read in ((base.ContentQuantity, '_as_quantity'), (base.ContentString, 'as_string'),
                           (base.ContentInteger, 'as_integer')):
            if isinstance(content, kind):
                return getattr(content, read)()
        return content.as_uint()
    if isinstance(variation, base.Group):
        return {part.cv_non_spare.cv_name: value_of(part.arg)
                for part in variation.arg if isinstance(part, base.Item)}
    if isinstance(variation, base.Extended):
        return {piece.cv_non_spare.cv_name: value_of(piece.arg)
                for part in variation.arg for piece in part if isinstance(piece, base.Item)}
    if isinstance(variation, base.Repetitive):
        return [value(inner) for inner in variation.arg]
    if isinstance(variation, base.Explicit):
        return variation.get_bytes().hex()
    return {name: value_of(item) for name, item in variation.arg.items()}


def write(folder, name, uap, category, expansion):
    if hasattr(uap, 'cv_uaps'):
        (item, _), names = uap.cv_selector
        profiles = [(uap.cv_uaps[names[case]], (item, case)) for case in names]
    else:
        profiles = [(uap.cv_record, None)]
    with open(f'{folder}/{name}.ast', 'wb') as blocks, open(f'{folder}/{name}.reference', 'w') as lines:
        for i in range(RECORDS):
            sent, values = record(*profiles[i % len(profiles)], expansion)
            blocks.write(bytes([category]) + (len(sent) + 3).to_bytes(2, 'big') + sent)
            lines.write(json.dumps({**values, '_c': category}) + '\n')


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    folder, categories = sys.argv[1], sys.argv[2:]
    os.makedirs(folder, exist_ok=True)
    found = [re.fullmatch(r'(Cat|Ref)_(\d{3})_(\d+)_(\d+)', name) for name in dir(generated)]
    found = [match for match in found if match and match[2] in categories]
    newest = {}
    for match in sorted(found, key=lambda match: (match[1], match[2], int(match[3]), int(match[4]))):
        category, edition = match[2], f'{match[3]}.{match[4]}'
        definition = getattr(generated, match[0])
        if match[1] == 'Cat':
            newest[category] = f'{category}={edition}', definition.cv_uap
            write(folder, *newest[category], int(category), None)
        else:
            name, uap = newest[category]
            write(folder, f'{name},{category}~RE={edition}', uap, int(category), definition.cv_expansion)


if __name__ == "__main__":
    main()
