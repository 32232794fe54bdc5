//! Frames, of which journal and snapshots consist: a head of 32 bytes, then the payload.
//!
//! ```text
//! magic u32 | length u32 | number u64 | durable u64 | previous crc u32 | crc u32 | payload
//! ```
//! Numbers are little endian. The crc is that of the head before it and of the payload.

use crate::codec::VALUE_BYTES_MAX;

/// The length of a head in bytes.
pub(crate) const HEAD_LEN: usize = 32;
/// `PSjf`: the magic number of a frame of the journal.
pub(crate) const JOURNAL: u32 = u32::from_le_bytes(*b"PSjf");
/// `PSsb`: the magic number of a block of a snapshot.
pub(crate) const SNAPSHOT: u32 = u32::from_le_bytes(*b"PSsb");

/// The head of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Head {
    /// The number of the frame: from 1, without a gap.
    pub(crate) number: u64,
    /// The last frame known to be durable when this one was written.
    pub(crate) durable: u64,
    /// The crc of the frame before.
    pub(crate) previous: u32,
}

/// The bytes of a frame, and its crc.
pub(crate) fn written(magic: u32, head: Head, payload: &[u8]) -> (Vec<u8>, u32) {
    let mut bytes = Vec::with_capacity(HEAD_LEN + payload.len());
    bytes.extend_from_slice(&magic.to_le_bytes());
    // Payloads come from the codec, whose limit is far below.
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

/// A frame whose crc is right.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoundFrame<'a> {
    pub(crate) head: Head,
    pub(crate) crc: u32,
    pub(crate) payload: &'a [u8],
}

impl SoundFrame<'_> {
    /// The length of the frame in bytes, with its head.
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
pub(crate) fn read(magic: u32, bytes: &[u8]) -> Option<SoundFrame<'_>> {
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
    Some(SoundFrame { head, crc: found, payload })
}

/// Every sound frame anywhere in `bytes`, wherever it begins, with its place.
pub(crate) fn scan(magic: u32, bytes: &[u8]) -> impl Iterator<Item = (usize, SoundFrame<'_>)> {
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
