"""Hardened XML reading: what is refused, and where the finding points."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.findings import Finding, ScenarioError
from openscenario.xml import MAX_ATTRIBUTE, MAX_DEPTH, parse_xml, read_xml


def refused(data: bytes) -> Finding:
    with pytest.raises(ScenarioError) as caught:
        parse_xml(data, "x.xml")
    return caught.value.findings[0]


def test_nodes_carry_tag_line_attributes_and_text() -> None:
    root = parse_xml(b'<a>\n  <b k="v">text</b>\n</a>', "x.xml").root
    child = root.children[0]
    assert (root.tag, child.tag, child.line, child.attributes, child.text) == ("a", "b", 2, {"k": "v"}, "text")


def test_path_numbers_repeated_tags() -> None:
    root = parse_xml(b"<a><b/><b><c/></b></a>", "x.xml").root
    assert root.children[1].children[0].path == "a/b[2]/c"


def test_comments_and_processing_instructions_are_dropped() -> None:
    assert parse_xml(b"<a><!-- no --><?no?><b/></a>", "x.xml").root.children[0].tag == "b"


def test_default_namespace_is_no_part_of_the_tag_and_a_prefix_is() -> None:
    root = parse_xml(b'<a xmlns="http://x" xmlns:xi="http://y"><xi:include href="/etc/passwd"/></a>', "x.xml").root
    assert (root.tag, root.children[0].tag) == ("a", "xi:include")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_encodings_with_and_without_byte_order_mark(encoding: str) -> None:
    assert parse_xml('<a k="Ж字"/>'.encode(encoding), "x.xml").root.get("k") == "Ж字"


def test_declared_encoding_is_used() -> None:
    assert (
        parse_xml('<?xml version="1.0" encoding="ISO-8859-1"?><a k="é"/>'.encode("latin-1"), "x.xml").root.get("k")
        == "é"
    )


@pytest.mark.parametrize("encoding", ["unicode_escape", "utf-7", "punycode", "no-such", "rot13"])
def test_an_encoding_that_is_none_of_text_is_refused(encoding: str) -> None:
    assert refused(f'<?xml version="1.0" encoding="{encoding}"?><a/>'.encode()).code == "xml.bad_encoding"


def test_a_byte_of_another_encoding_is_located() -> None:
    finding = refused(b'<?xml version="1.0" encoding="UTF-8"?>\n<a>\n<b name="caf\xe9"/></a>')
    assert (finding.code, finding.line, finding.element) == ("xml.bad_encoding", 3, "b@name")


def test_a_nul_character_is_located_and_does_not_end_the_file() -> None:
    finding = refused(b'<a>\n<b name="x\x00y"/></a>')
    assert (finding.code, finding.line, finding.element) == ("xml.not_well_formed", 2, "b@name")


@pytest.mark.parametrize(
    "doctype",
    [
        "<!DOCTYPE a>",
        '<!DOCTYPE a SYSTEM "http://127.0.0.1:9/x.dtd">',
        '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE a [<!ENTITY % x SYSTEM "x.dtd"> %x;]>',
        "<!doctype a>",
    ],
)
def test_any_doctype_is_refused_before_parsing(doctype: str) -> None:
    finding = refused(f'<?xml version="1.0"?>\n<!-- <a> --><?p?>\n{doctype}\n<a>&x;</a>'.encode())
    assert (finding.code, finding.line, finding.element) == ("xml.dtd_forbidden", 3, "DOCTYPE")


def test_a_doctype_in_utf_16_is_refused_as_well() -> None:
    assert refused('<!DOCTYPE a [<!ENTITY x "y">]><a>&x;</a>'.encode("utf-16")).code == "xml.dtd_forbidden"


def test_an_entity_without_doctype_is_not_well_formed() -> None:
    assert refused(b"<a>&x;</a>").code == "xml.not_well_formed"


@pytest.mark.parametrize("data", [b"", b"   \n ", b"\xef\xbb\xbf"])
def test_an_empty_file_is_said_to_be_empty(data: bytes) -> None:
    assert refused(data).code in ("xml.empty", "xml.not_well_formed")


def test_a_cut_file_is_located_at_its_end() -> None:
    finding = refused(b"<a>\n<b>\n<c")
    assert (finding.code, finding.line) == ("xml.not_well_formed", 3)


@pytest.mark.parametrize("depth", [MAX_DEPTH + 1, 100_000])
def test_too_deep_nesting_is_refused(depth: int) -> None:
    assert refused(b"<a>" * depth + b"</a>" * depth).code == "xml.too_deep"


def test_nesting_up_to_the_limit_is_read() -> None:
    assert parse_xml(b"<a>" * MAX_DEPTH + b"</a>" * MAX_DEPTH, "x.xml").root.tag == "a"


def test_a_long_attribute_is_refused_and_not_printed() -> None:
    finding = refused(b'<a>\n<b k="' + b"x" * (MAX_ATTRIBUTE + 1) + b'"/></a>')
    assert (finding.code, finding.line, finding.element) == ("xml.attribute_too_long", 2, "b@k")
    assert len(str(finding)) < 300


def test_a_missing_file_is_a_finding(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"path\.not_found"):
        read_xml(tmp_path / "none.xosc")


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"path\.not_a_file"):
        read_xml(tmp_path)


def test_a_file_beyond_the_size_limit_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "big.xml").write_bytes(b"<a/>" + b" " * 100)
    with pytest.raises(ScenarioError, match=r"xml\.too_big"):
        read_xml(tmp_path / "big.xml", max_bytes=50)


@pytest.mark.parametrize(
    "inner",
    [
        b'<b k="v">text</b>',
        b"<b>before<c/>after</b>",
        b"<b>one<!-- x -->two<?x y?>three</b>",
        b"<b><![CDATA[<raw> & such]]></b>",
        b'<b k="&lt;&#65;&amp;\t&#10;">&gt;&#x42;</b>',
        b"\r\n<b/>\r\n  <c>\r\n</c>",
        b'\n<b\n  k="v"/>\n<c/>',
        "<größe wert='ä€𝄞'/>".encode(),
    ],
)
def test_a_namespace_that_nobody_uses_changes_nothing(inner: bytes) -> None:
    """Files with and without namespaces take different parsers."""

    def seen(data: bytes) -> list[tuple[str, int, dict[str, str], str]]:
        nodes = parse_xml(data, "x.xml").root.walk()
        return [(node.tag, node.line, node.attributes, node.text) for node in nodes]

    without, unused = seen(b"<a>" + inner + b"</a>"), seen(b'<a xmlns:x="http://x">' + inner + b"</a>")
    assert without == unused
    assert without[1][1] > 0


@pytest.mark.parametrize("data", [b"<a><x:b/></a>", b'<a><b x:k="1"/></a>'])
def test_a_prefix_that_is_not_declared_is_refused(data: bytes) -> None:
    assert refused(data).code == "xml.not_well_formed"
