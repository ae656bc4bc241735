"""What a recording holds, of ASTERIX or of all topics (.mcap): what_is_in.py FILE [CATEGORY=EDITION ...]"""

import sys
from collections import Counter

import koseki

if sys.argv[1].endswith(".mcap"):
    for topic, samples in sorted(koseki.read(sys.argv[1]).items()):
        print(f"{topic}: {len(samples)} samples")
    sys.exit()

editions = {int(category): edition for category, edition in (word.split("=") for word in sys.argv[2:])}
records, items = Counter(), Counter()
for record in koseki.decode(sys.argv[1], editions=editions):
    category = record["_c"]
    records[category] += 1
    items.update((category, item) for item in record if not item.startswith("_"))
for category, count in sorted(records.items()):
    print(f"category {category}: {count} records")
    for (of, item), times in sorted(items.items()):
        if of == category:
            print(f"  I{category:03}/{item}: in {times / count:.0%}")
