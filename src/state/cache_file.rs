//! The file of an irradiance cache, which the shards of a render share.
//!
//! A file has these parts: `ETDCACHE`; the identity of the render, as JSON, and the records in the order in which they were
//! inserted, both in the form of `postcard`; BLAKE3 of all bytes before.
//!
//! Measure: as in [`Record`].
//! Range: a file that was cut or changed, and that of another render, is an error.
//! Source: our own format. Tested in `cli/tests/command/shared_cache.rs`.

use super::file::{read_bytes, with_checksum};
use super::fingerprint::Fingerprint;
use crate::error::{Error, ErrorKind, Result};
use crate::image::atomic::{ExistingFile, write_durably};
use crate::integrator::irradiance_cache::{IrradianceCache, Record};
use std::io::Write;
use std::path::Path;

/// The first bytes of the file.
const MAGIC: &[u8; 8] = b"ETDCACHE";

/// Writes the cache of a render of this identity, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write(cache: &IrradianceCache, identity: &Fingerprint, path: &Path) -> Result<()> {
    let failed = |error| Error::render("cannot write the irradiance cache").because(error);
    let identity = serde_json::to_string(identity)
        .map_err(|error| Error::render("cannot write the identity").because(error))?;
    let bytes = postcard::to_extend(&(identity, cache.records()), MAGIC.to_vec());
    let bytes = with_checksum(bytes.map_err(failed)?);
    write_durably(path, ExistingFile::Replace, |writer| {
        writer.write_all(&bytes)
    })
}

/// Reads the cache of a render of this identity, whose allowed error is `bound`.
///
/// # Errors
/// A file that cannot be read or is damaged, or the cache of another render.
pub fn read(path: &Path, identity: &Fingerprint, bound: f64) -> Result<IrradianceCache> {
    let bytes = read_bytes(path)?;
    decode(&bytes, identity, bound).map_err(|error| error.in_file(path))
}

fn decode(bytes: &[u8], identity: &Fingerprint, bound: f64) -> Result<IrradianceCache> {
    let no_cache = |what: &str| {
        Error::new(
            ErrorKind::Io,
            format!("is not the file of an irradiance cache: {what}"),
        )
    };
    let Some(after_magic) = bytes.strip_prefix(MAGIC) else {
        return Err(no_cache("expected one that --cache wrote"));
    };
    let content = after_magic.split_last_chunk::<{ blake3::OUT_LEN }>();
    let is_whole = |content: &[u8], checksum: &[u8]| {
        blake3::hash(&bytes[..MAGIC.len() + content.len()]).as_bytes() == checksum
    };
    let Some((content, _)) = content.filter(|(content, sum)| is_whole(content, *sum)) else {
        return Err(no_cache("it was cut or changed"));
    };
    let (theirs, records): (String, Vec<Record>) = postcard::from_bytes(content)
        .map_err(|error| no_cache("its records cannot be read").because(error))?;
    let theirs: Fingerprint = serde_json::from_str(&theirs)
        .map_err(|error| no_cache("its identity cannot be read").because(error))?;
    let differences = identity.differences(&theirs, "this render", "the cache");
    if !differences.is_empty() {
        return Err(Error::usage(format!(
            "is the cache of another render: {}",
            differences.join("; ")
        )));
    }
    IrradianceCache::with_records(bound, records)
        .ok_or_else(|| no_cache("it has impossible records"))
}
