//! Frames: what journal and snapshots are made of. 32 bytes of head, then the payload.
//!
//! ```text
//! magic u32 | length u32 | number u64 | durable u64 | previous crc u32 | crc u32 | payload
//! ```
//! Little endian. The crc is over all that comes before it and the payload.

use crate::codec::VALUE_BYTES_MAX;

/// Bytes of a head.
pub(crate) const HEAD_LEN: usize = 32;
/// `PSjf`: what begins a frame of the journal.
pub(crate) const JOURNAL: u32 = u32::from_le_bytes(*b"PSjf");
/// `PSsb`: what begins a block of a snapshot.
pub(crate) const SNAPSHOT: u32 = u32::from_le_bytes(*b"PSsb");

/// What a head says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Head {
    /// The frame's number: from 1, without a gap.
    pub(crate) number: u64,
    /// The last frame known to be durable when this one was written.
    pub(crate) durable: u64,
    /// The crc of the frame before.
    pub(crate) previous: u32,
}

/// A frame as bytes, with its crc.
pub(crate) fn written(magic: u32, head: Head, payload: &[u8]) -> (Vec<u8>, u32) {
    let mut bytes = Vec::with_capacity(HEAD_LEN + payload.len());
    bytes.extend_from_slice(&magic.to_le_bytes());
    // Payloads are made by the codec, which keeps to a limit far below.
    bytes.extend_from_slice(&u32::try_from(payload.len()).unwrap_or(u32::MAX).to_le_bytes());
    bytes.extend_from_slice(&head.number.to_le_bytes());
    bytes.extend_from_slice(&head.durable.to_le_bytes());
    bytes.extend_from_slice(&head.previous.to_le_bytes());
    let crc = crc(&bytes, payload);
    bytes.extend_from_slice(&crc.to_le_bytes());
    bytes.extend_from_slice(payload);
    (bytes, crc)
}

fn crc(head: &[u8], payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(head);
    hasher.update(payload);
    hasher.finalize()
}

/// A frame that was found sound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found<'a> {
    pub(crate) head: Head,
    pub(crate) crc: u32,
    pub(crate) payload: &'a [u8],
}

impl Found<'_> {
    /// Bytes it takes.
    pub(crate) fn len(&self) -> usize {
        HEAD_LEN + self.payload.len()
    }
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at + N)?.try_into().ok()
}

/// The length of the payload that the head at the beginning of `bytes` claims.
pub(crate) fn length(bytes: &[u8]) -> Option<usize> {
    Some(u32::from_le_bytes(number(bytes.get(..HEAD_LEN)?, 4)?) as usize)
}

/// The frame at the beginning of `bytes`; none unless it is whole and sound.
pub(crate) fn read(magic: u32, bytes: &[u8]) -> Option<Found<'_>> {
    if u32::from_le_bytes(number(bytes, 0)?) != magic {
        return None;
    }
    let length = u32::from_le_bytes(number(bytes, 4)?) as usize;
    if length > VALUE_BYTES_MAX {
        return None;
    }
    let payload = bytes.get(HEAD_LEN..HEAD_LEN + length)?;
    let found = u32::from_le_bytes(number(bytes, 28)?);
    if found != crc(bytes.get(..28)?, payload) {
        return None;
    }
    let head = Head {
        number: u64::from_le_bytes(number(bytes, 8)?),
        durable: u64::from_le_bytes(number(bytes, 16)?),
        previous: u32::from_le_bytes(number(bytes, 24)?),
    };
    Some(Found { head, crc: found, payload })
}

/// Every sound frame anywhere in `bytes`, wherever it begins, with its place.
pub(crate) fn scan(magic: u32, bytes: &[u8]) -> impl Iterator<Item = (usize, Found<'_>)> {
    let mut at = 0;
    let magic_bytes = magic.to_le_bytes();
    std::iter::from_fn(move || {
        loop {
            let rest = bytes.get(at..)?;
            at += rest.windows(4).position(|window| window == magic_bytes)?;
            if let Some(found) = bytes.get(at..).and_then(|rest| read(magic, rest)) {
                let place = at;
                at += found.len();
                return Some((place, found));
            }
            at += 1;
        }
    })
}
