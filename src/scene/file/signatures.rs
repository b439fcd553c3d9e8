//! Recognition of files that were given as OBJ but are something else, by their first bytes.

/// First bytes of files of other kinds, and their names; the first match counts.
const SIGNATURES: [(&[u8], &str); 35] = [
    (b"\xff\xfe\0\0", "text in UTF-32: save it as UTF-8"),
    (b"\xff\xfe", "text in UTF-16: save it as UTF-8"),
    (b"\xfe\xff", "text in UTF-16: save it as UTF-8"),
    (
        b"version https://git-lfs",
        "a pointer of Git LFS: fetch the file itself with \"git lfs pull\"",
    ),
    (b"ply\n", "a PLY mesh"),
    (b"ply\r", "a PLY mesh"),
    (b"solid", "an STL mesh"),
    (b"glTF", "a glTF scene (GLB)"),
    (b"{", "JSON, perhaps a glTF scene"),
    (b"Kaydara FBX", "an FBX scene"),
    (b"; FBX", "an FBX scene"),
    (b"BLENDER", "a Blender scene"),
    (b"#usda", "a USD scene"),
    (b"PXR-USDC", "a USD scene"),
    (b"#VRML", "a VRML scene"),
    (b"ISO-10303-21", "a STEP model"),
    (b"Ogawa", "an Alembic scene"),
    (b"OFF", "an OFF mesh"),
    (b"MM", "a 3DS scene"),
    (
        b"<!DOCTYPE html",
        "a web page (HTML): download the file itself",
    ),
    (
        b"<!doctype html",
        "a web page (HTML): download the file itself",
    ),
    (b"<html", "a web page (HTML): download the file itself"),
    (b"<", "XML, perhaps a COLLADA or X3D scene"),
    (b"PK\x03\x04", "a zip archive: unpack it"),
    (b"\x1f\x8b", "compressed by gzip: unpack it"),
    (b"7z\xbc\xaf", "a 7z archive: unpack it"),
    (b"Rar!", "a RAR archive: unpack it"),
    (b"BZh", "compressed by bzip2: unpack it"),
    (b"\xfd7zXZ", "compressed by xz: unpack it"),
    (
        b"\x28\xb5\x2f\xfd",
        "compressed by zstd, perhaps a Blender scene",
    ),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"\x76\x2f\x31\x01", "an EXR image"),
    (b"%PDF", "a PDF document"),
    (b"[", "a TOML or JSON text"),
];

/// Returns the kind of a file that is certainly no OBJ.
pub(super) fn kind(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    if text.is_empty() {
        return Some("empty");
    }
    // Binary STL may begin with any 80 bytes, followed by the number of its triangles, of 50 bytes
    // each.
    let count = bytes.get(80..84).map(|count| {
        count
            .iter()
            .rev()
            .fold(0u64, |sum, byte| (sum << 8) | u64::from(*byte))
    });
    if count.is_some_and(|count| bytes.len() as u64 == 84 + 50 * count) {
        return Some("an STL mesh");
    }
    let known = SIGNATURES
        .iter()
        .find(|(start, _)| text.starts_with(start))
        .map(|(_, kind)| *kind);
    known.or_else(
        || match bytes.iter().take(4096).position(|byte| *byte == 0) {
            Some(0 | 1) if bytes.len().is_multiple_of(2) => {
                Some("text in UTF-16, or binary: save it as UTF-8")
            }
            Some(_) => Some("a binary file"),
            None => None,
        },
    )
}
