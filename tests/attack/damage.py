"""Damages good files by name, type, size, nesting and encoding, knowing what kind of file they are.

Every function takes a random.Random and the good content, and gives the damaged content.
"""
import hashlib
import json
import re
import struct
import zlib

# Text that would become code, markup, a path or another line in a writer that does not quote it.
NAMES = [
    "", " ", ".", "..", "../../x", "/abs", "-x", "--help", "a/b", "a\\b", "a\nb", "a\r\nb", "a\tb",
    "a\x00b", "\x1b[31mred", "a\u202eb", "\ufeff", "'", '"', "`touch marker`", "$(touch marker)",
    "| touch marker", "< touch marker", "'; touch marker; '", "a'\nsystem('touch marker')\n#",
    "&lt;&#10;", "<script>", "]]>", "%s%n%d", "@x", "\\", "a\\", "{}", "{0}", "{name}", "$HOME",
    "oracle", "simulator", "nan", "x" * 300, "x" * 100_000, "ä" * 101, "😀", "con", "joint_a1",
]
NUMBERS = [
    "0", "-0", "-1", "1", "2", "3", "7", "0.5", "1e-300", "1e300", "1e308", "1e400", "-1e400",
    "1e-400", "nan", "inf", "-inf", "2147483647", "2147483648", "-2147483649", "4294967296",
    "9223372036854775807", "9223372036854775808", "99999999999999999999", "1000000", "1e6", "1e9",
    "0x10", "1_000", "010", "+1", "1.", ".5", "1,5", "true",
]
OTHERS = [
    "true", "false", "[]", "{}", "[[]]", "[1, 2, 3]", "[nan]", '["a"]', '""', '"text"', "1979-05-27",
    "07:32:00", "[1, \"a\"]", "{a = 1}", "'''x'''", "null", "[" * 200 + "]" * 200,
]


def toml_string(text):
    return json.dumps(text, ensure_ascii=False)


def any_value(rng):
    """A TOML value of any type."""
    kind = rng.randrange(4)
    if kind == 0:
        return rng.choice(NUMBERS)
    if kind == 1:
        return toml_string(rng.choice(NAMES))
    if kind == 2:
        return rng.choice(OTHERS)
    return "[" + ", ".join(rng.choice(NUMBERS) for _ in range(rng.choice([1, 2, 6, 7, 1000]))) + "]"


def encoding(rng, data):
    """Bytes in another encoding, cut, doubled or with foreign bytes; for every kind of file."""
    kind = rng.randrange(9)
    at = rng.randrange(len(data) + 1)
    if kind == 0:
        return data[:at]
    if kind == 1:
        return b"\xef\xbb\xbf" + data
    if kind == 2:
        return data.decode("latin-1").encode(rng.choice(["utf-16", "utf-32"]))
    if kind == 3:
        return data[:at] + bytes(rng.randrange(256) for _ in range(rng.randrange(1, 30))) + data[at:]
    if kind == 4:
        return data[:at] + b"\0" + data[at:]
    if kind == 5:
        return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b""]))
    if kind == 6:
        return data + data
    if kind == 7:
        return b""
    damaged = bytearray(data)
    for _ in range(rng.randrange(1, 5)):
        if damaged:
            damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
    return bytes(damaged)


def text(rng, data):
    """Any text: lines gone, doubled or of other words."""
    lines = data.decode().split("\n")
    for _ in range(rng.choice([1, 2, 5])):
        i = rng.randrange(len(lines))
        lines[i] = rng.choice(["", lines[i] * 2, rng.choice(NAMES), lines[i] + rng.choice(NAMES),
                               "# " + rng.choice(NAMES)])
    return "\n".join(lines).encode("utf-8", "replace")


def toml(rng, data):
    lines = data.decode().split("\n")
    keys = [i for i, line in enumerate(lines) if re.match(r"\w+ = ", line)]
    tables = [i for i, line in enumerate(lines) if line.startswith("[")]
    for _ in range(rng.choice([1, 1, 1, 2, 5])):
        i = rng.choice(keys)
        key, _, value = lines[i].partition(" = ")
        kind = rng.randrange(12)
        if kind < 5:
            lines[i] = f"{key} = {any_value(rng)}"
        elif kind == 5:  # one number of an array
            lines[i] = f"{key} = " + re.sub(r"[-\d.e]+", lambda m: rng.choice(
                [m[0], m[0], rng.choice(NUMBERS)]), value)
        elif kind == 6:
            lines[i] = rng.choice(["", lines[i] + "\n" + lines[i], f"{key}x = {value}"])
        elif kind == 7:
            name = rng.choice(NAMES)
            lines[i] = f"{toml_string(name)} = {value}"
        elif kind == 8:
            depth = rng.choice([10, 40, 1000, 100_000])
            lines[i] = rng.choice([
                ".".join(["a"] * depth) + " = 1", f"{key} = " + "[" * depth + "]" * depth,
                f"{key} = " + "{a = " * depth + "1" + "}" * depth,
                "[" + ".".join(["b"] * depth) + "]"])
        elif kind == 9 and tables:
            j = rng.choice(tables)
            lines[j] = rng.choice(["", lines[j] + "\n" + lines[j], f"[{lines[j]}]", "[[model]]",
                                   "[friction]", lines[j][:-1], "[x]"])
        elif kind == 10:
            lines.insert(0, rng.choice([
                'extends = "scene.toml"', "extends = []", 'extends = ["a", "b"]', "extends = 3",
                'extends = "/dev/zero"', 'extends = "/"', 'extends = "loop"', 'extends = ""',
                "extends = [" + ", ".join(['"empty.toml"'] * 20_000) + "]"]))
        else:
            j = rng.choice(keys)
            lines[i], lines[j] = lines[j], lines[i]
    return "\n".join(lines).encode()


def places(node, path=()):
    """Every place in a tree of lists and objects."""
    yield path
    if isinstance(node, dict):
        for key in node:
            yield from places(node[key], path + (key,))
    elif isinstance(node, list):
        for i in range(len(node)):
            yield from places(node[i], path + (i,))


def value_at(root, path):
    for step in path:
        root = root[step]
    return root


class Raw(float):
    """A number that is written as it is given, however wrong."""

    def __new__(cls, text):
        number = super().__new__(cls, 0)
        number.text = text
        return number

    def __repr__(self):
        return self.text


def json_value(rng):
    kind = rng.randrange(4)
    if kind == 0:
        return rng.choice(NAMES)
    if kind == 1:
        return rng.choice([None, True, False, [], {}, [[]], [None], {"a": 1}, [1, "a"], "1"])
    if kind == 2:
        return [0.5] * rng.choice([1, 2, 6, 7, 1000])
    return Raw(rng.choice(["0", "-1", "1", "3", "0.5", "1e300", "-1e300", "1e-300", "1e400",
                           "2147483648", "9223372036854775808", "1000000", "4294967297", "1e9"]))


def write_json(node):
    """As json.dumps, with Raw numbers."""
    if isinstance(node, Raw):
        return node.text
    if isinstance(node, dict):
        return "{" + ", ".join(json.dumps(k) + ": " + write_json(v) for k, v in node.items()) + "}"
    if isinstance(node, list):
        return "[" + ", ".join(map(write_json, node)) + "]"
    return json.dumps(node)


def resize_lists(rng, node, size, new):
    """Every list of `size` entries gets `new`: lists agree in length as before."""
    for child in (node.values() if isinstance(node, dict) else node if isinstance(node, list) else []):
        resize_lists(rng, child, size, new)
    if isinstance(node, list) and len(node) == size:
        node[:] = [json.loads(write_json(rng.choice(node))) for _ in range(new)] if size else [0.5] * new


def json_file(rng, data):
    root = json.loads(data)
    all_places = list(places(root))[1:]
    if rng.randrange(8) == 0:
        resize_lists(rng, root, rng.choice([1, 2, 2, 3]), rng.choice([0, 1, 2, 3, 50]))
        return write_json(root).encode()
    if rng.randrange(8) == 0:  # one number, everywhere
        numbers = [p for p in all_places if isinstance(value_at(root, p), (int, float))]
        old, new = value_at(root, rng.choice(numbers)), json_value(rng)
        for path in numbers:
            if value_at(root, path) == old:
                value_at(root, path[:-1])[path[-1]] = new
        return write_json(root).encode()
    for _ in range(rng.choice([1, 1, 1, 2, 5])):
        path = rng.choice(all_places)
        parent = root
        try:
            for step in path[:-1]:
                parent = parent[step]
            kind = rng.randrange(8)
            if kind < 4:
                parent[path[-1]] = json_value(rng)
            elif kind == 4:
                del parent[path[-1]]
            elif kind == 5 and isinstance(parent, dict):
                parent[rng.choice(NAMES)] = parent.pop(path[-1])
            elif kind == 5:
                parent.extend(parent[:] * rng.choice([1, 3]))
            elif kind == 6:
                other = rng.choice(all_places)
                value = root
                for step in other:
                    value = value[step]
                parent[path[-1]] = json.loads(write_json(value))
            else:
                depth = rng.choice([20, 40, 100_000])
                text = write_json(root)
                return (text[:-1] + ', "deep": ' + "[" * depth + "]" * depth + "}").encode()
        except (KeyError, IndexError, TypeError, ValueError, AttributeError):
            continue
    return write_json(root).encode()


MJCF_PARTS = [
    '<include file="robot.xml"/>', '<include file="/dev/zero"/>', '<include file="none.xml"/>',
    '<include file="log.csv"/>', '<asset><mesh name="m" file="none.stl"/></asset>',
    '<asset><mesh name="m" file="/dev/zero"/></asset>', '<asset><mesh name="m" file="log.csv"/></asset>',
    '<asset><hfield name="h" file="log.csv" size="1 1 1 1"/></asset>', '<option timestep="0"/>',
    '<option timestep="-1" integrator="RK4"/>', '<size memory="1000G"/>', '<size njmax="2147483647"/>',
    '<extension><plugin plugin="x"/></extension>', '<compiler meshdir="../.."/>',
    '<equality><joint joint1="shoulder" joint2="elbow"/></equality>',
    '<actuator><motor joint="shoulder"/></actuator>', '<sensor><jointpos joint="shoulder"/></sensor>',
    '<worldbody><body><freejoint/><geom size="1"/></body></worldbody>',
    '<worldbody><body><joint type="ball"/><geom size="1e300"/></body></worldbody>',
    "<default><default><default/></default></default>", '<statistic extent="nan"/>',
    '<visual><global offwidth="100000000"/></visual>', '<keyframe><key qpos="nan nan"/></keyframe>']


def xml(rng, data):
    """URDF and MJCF: values of attributes, elements gone, doubled or nested."""
    text = data.decode()
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        attributes = list(re.finditer(r'(\w+)="([^"]*)"', text))
        elements = list(re.finditer(r"<(\w+)[^<>]*/>", text))
        kind = rng.randrange(11)
        if kind < 5 and attributes:
            a = rng.choice(attributes)
            numbers = a[2].split()
            if rng.randrange(3) == 0:
                value = rng.choice(NAMES)
            elif rng.randrange(4) == 0:
                value = " ".join(rng.choice(NUMBERS) for _ in range(rng.choice([0, 1, 2, 4, 1000])))
            else:
                at = rng.randrange(len(numbers) or 1)
                numbers[at:at + 1] = [rng.choice(NUMBERS)]
                value = " ".join(numbers)
            if rng.randrange(2):
                value = value.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
            text = text[:a.start(2)] + value + text[a.end(2):]
        elif kind == 5 and attributes:
            a = rng.choice(attributes)
            text = text[:a.start()] + rng.choice(["", a[0] + " " + a[0], "x=1"]) + text[a.end():]
        elif kind == 6 and elements:
            e = rng.choice(elements)
            text = text[:e.start()] + rng.choice(["", e[0] * 2, e[0] * 3000]) + text[e.end():]
        elif kind == 7:
            depth = rng.choice([100, 600, 100_000])
            at = text.rindex("</")
            text = text[:at] + "<a>" * depth + "</a>" * depth + text[at:]
        elif kind == 8 and "<mujoco" in text:
            part = rng.choice(MJCF_PARTS)
            at = text.rindex("</") if rng.randrange(2) else text.index(">") + 1
            text = text[:at] + part + text[at:]
        elif kind == 9:
            names = re.findall(r'name="([^"]*)"', text) or ["none"]
            text = text.replace(f'"{rng.choice(names)}"', f'"{rng.choice(names)}"')
        else:
            count = rng.choice([10, 2000, 60_000])
            links = "".join(
                f'<link name="l{i}"/><joint name="j{i}" type="fixed"><parent link="l{i - 1}"/>'
                f'<child link="l{i}"/></joint>' for i in range(1, count))
            at = text.rindex("</robot>") if "</robot>" in text else len(text)
            text = text[:at] + '<link name="l0"/>' + links + text[at:]
    return text.encode("utf-8", "replace")


def csv(rng, data):
    rows = [line.split(",") for line in data.decode().strip().split("\n")]
    for _ in range(rng.choice([1, 1, 2, 5])):
        kind = rng.randrange(11)
        row = rng.randrange(len(rows))
        column = rng.randrange(len(rows[row]))
        if kind < 3:
            rows[row][column] = rng.choice(NUMBERS + ["", "abc", '"1"'])
        elif kind == 3:
            rows[0][rng.randrange(len(rows[0]))] = rng.choice(NAMES)
        elif kind == 4:
            rows[row] = rows[row] * rng.choice([0, 2, 1000])
            rows = [r for r in rows if r] or [["t"]]
        elif kind == 5:
            rows = rows[:row + 1] + rows[row:]
        elif kind == 6:
            rows = rows[:1] + rows[row + 1:] or [["t"]]
        elif kind == 7:  # a gap, or a clock that goes back
            shift = rng.choice([1, 60, 1e5, 1e8, 1e12, -1, -1e6])
            for later in rows[max(1, row):]:
                try:
                    later[0] = repr(float(later[0]) + shift)
                except ValueError:
                    continue
        elif kind == 8:  # long lines, many columns
            rows[row] = rng.choice([["x" * 10_000_000], ["1"] * 200_000, rows[row] * 50_000])
        elif kind == 9:  # two columns of one name
            rows[0][column] = rng.choice(rows[0])
        else:  # a column that is constant, or huge
            value = rng.choice(["0", "1e300", "nan", "-0.0", "1e-300", "1e15"])
            for later in rows[1:]:
                if column < len(later):
                    later[column] = value
    return "\n".join(map(",".join, rows)).encode("utf-8", "replace") + b"\n"


HEADER = 512  # bytes before the HDF5 file that the program keeps for itself


def sealed(data):
    """A file of ours with the checksum that its bytes have now."""
    rest = data[HEADER:]
    text = data[:data.index(b"\n")] + b"\nsha256 from byte %d on: %s\n" % (
        HEADER, hashlib.sha256(rest).hexdigest().encode())
    return text.ljust(HEADER, b"\0") + rest


def hdf5(rng, data):
    """Damage inside the file, most of it under a checksum that fits."""
    rest = bytearray(data)
    kind = rng.randrange(8)
    if kind == 0:
        return encoding(rng, data)
    if kind < 4:  # a declared size
        number = struct.unpack_from("<Q", rest, rng.randrange(HEADER, len(rest) - 8))[0]
        sizes = [m.start() for m in re.finditer(re.escape(struct.pack("<Q", rows_of(data))), rest)]
        at = rng.choice(sizes) if sizes else rng.randrange(HEADER, len(rest) - 8)
        value = rng.choice([0, 1, 2, 3, 1 << 20, 1 << 31, 1 << 40, (1 << 62) + 1, (1 << 64) - 1,
                            number])
        for place in (sizes if rng.randrange(2) else [at]):
            struct.pack_into("<Q", rest, place, value)
    elif kind < 6:  # a name or a text
        words = [m for m in re.finditer(rb"[a-zA-Z_][\w./ ]{1,30}", bytes(rest[HEADER:]))]
        word = rng.choice(words)
        new = rng.choice(NAMES).encode("utf-8", "replace")[:len(word[0])].ljust(len(word[0]), b"\0")
        rest[HEADER + word.start():HEADER + word.end()] = new
    else:
        for _ in range(rng.choice([1, 1, 3, 20])):
            at = rng.randrange(HEADER, min(len(rest), rng.choice([HEADER + 3000, len(rest)])))
            rest[at] = rng.choice([rest[at] ^ (1 << rng.randrange(8)), 0, 255, rng.randrange(256)])
    return sealed(bytes(rest))


def rows_of(data):
    """The number of rows of the tables: the number that stands most often twice in a row, but
    for the few joints."""
    counts = {}
    for at in range(HEADER, min(len(data), HEADER + 20_000) - 16):
        first, second = struct.unpack_from("<QQ", data, at)
        if first == second and 16 < first < 1 << 30:
            counts[first] = counts.get(first, 0) + 1
    return max(counts, key=counts.get, default=2)


def zstd_of_zeros(size):
    """A zstd frame of `size` zero bytes: blocks of 128 kB, each one byte to be repeated."""
    block, frame = 128 * 1024, struct.pack("<IBB", 0xFD2FB528, 0, 0x38)
    while True:
        now = min(size, block)
        size -= now
        frame += struct.pack("<I", now << 3 | 1 << 1 | (size == 0))[:3] + b"\0"
        if size == 0:
            return frame


def mcap(rng, data):
    kind = rng.randrange(6)
    if kind == 0:
        return encoding(rng, data)
    if kind == 1:  # chunks that say and hold much
        size = rng.choice([1, 1 << 20, 1 << 28, 1 << 30])
        said = rng.choice([size, size - 1, 1 << 40, 0])
        stored = zstd_of_zeros(min(size, 1 << 28))
        chunk = struct.pack("<QQQI", 0, 0, said, 0) + text32(rng.choice(["zstd", "lz4", "xz", ""]))
        chunk += struct.pack("<Q", rng.choice([len(stored), 1 << 50])) + stored
        record = b"\x06" + struct.pack("<Q", len(chunk)) + chunk
        return data[:8] + record * rng.choice([1, 3, 40]) + data[8:]
    return with_numbers(rng, data, 8)


def mat(rng, data):
    """A MAT-file, of which all fields are little-endian."""
    kind = rng.randrange(6)
    if kind == 0:
        return encoding(rng, data)
    if kind == 1:  # zeros that take much more memory than they take in the file
        stored = zlib.compress(bytes(rng.choice([1, 1 << 20, 1 << 28])))
        return data + struct.pack("<II", 15, rng.choice([len(stored), 1 << 31])) + stored
    if kind == 2:  # structures in structures
        array = b""
        for _ in range(rng.choice([2, 40, 3000])):
            array = mat_structure(array)
        return data + array
    return with_numbers(rng, data, 4)


def mat_structure(array):
    """A structure with the field f, which is `array`, of a MAT-file."""
    content = struct.pack("<8I", 6, 8, 2, 0, 5, 8, 1, 1) + struct.pack("<2I", 1 | 1 << 16, ord("S"))
    content += struct.pack("<4I", 5 | 4 << 16, 4, 1, 4) + b"f\0\0\0" + bytes(4) + array
    return struct.pack("<II", 14, len(content)) + content


def db3(rng, data):
    """Header, schema, cells and pages of an SQLite file, of which all fields are big-endian."""
    kind = rng.randrange(4)
    if kind == 0:
        return encoding(rng, data)
    if kind == 1:  # pages in other places
        size = 4096
        pages = [data[at:at + size] for at in range(0, len(data), size)]
        pages[rng.randrange(1, len(pages))] = rng.choice(pages)
        return b"".join(pages)
    if kind == 2:  # one word of the schema
        words = [b"messages", b"topics", b"data", b"TABLE", b"INTEGER", b"BLOB", b"KEY"]
        word, other = rng.choice(words), rng.choice(words)
        return data.replace(word, (other + b" " * 8)[:len(word)], rng.choice([1, 2]))
    return with_numbers(rng, data, 16, ">")


def with_numbers(rng, data, begin, order="<"):
    """A few numbers written over what is there from `begin` on."""
    damaged = bytearray(data)
    for _ in range(rng.choice([1, 1, 3])):
        at = rng.randrange(begin, len(damaged) - 8)
        form, most = rng.choice([("I", 1 << 32), ("Q", 1 << 64), ("H", 1 << 16), ("d", None)])
        value = (rng.choice([float("nan"), float("inf"), 1e300, -1e9]) if most is None else
                 rng.choice([0, 1, most - 1, most >> 1, rng.randrange(most)]))
        struct.pack_into(order + form, damaged, at, value)
    return bytes(damaged)


def text32(text):
    return struct.pack("<I", len(text)) + text.encode()
