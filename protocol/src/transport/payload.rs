//! The promises about shared types that iceoryx2 asks for, and the writing of a part of a large message in place.
//! This is the only module of the crate with `unsafe` code.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::request_mut::RequestMut;
use iceoryx2::request_mut_uninit::RequestMutUninit;

use super::services::Ipc;
use crate::limits::{OBSERVATIONS_MAX, PRIMITIVES_MAX};
use crate::wire::message::{RawFrame, RawHello};
use crate::wire::{
    FrameHeader, HelloHead, Page, PictureHeader, Record, Welcome, WireFrame, WireHello, WireReply,
};

/// Gives wire types the names by which iceoryx2 knows them. It compares name, size and alignment when a service is opened.
macro_rules! shared {
    ($($type:ty => $name:literal),+ $(,)?) => {$(
        // SAFETY: the type is repr(C), made of integers and arrays of them only (see `wire`, which asserts
        // that there is no padding), holds no pointer, and every bit pattern of it is valid.
        unsafe impl ZeroCopySend for $type {
            // SAFETY: the version in the name is bumped at every change of layout.
            unsafe fn type_name() -> &'static str {
                $name
            }
        }
    )+};
}

shared! {
    WireHello => "pschema.Hello.v1",
    Welcome => "pschema.Welcome.v2",
    FrameHeader => "pschema.FrameHeader.v1",
    WireFrame => "pschema.Frame.v2",
    WireReply => "pschema.Reply.v1",
    Page => "pschema.Page.v1",
    PictureHeader => "pschema.Picture.v1",
}

type LoanedHello = RequestMutUninit<Ipc, MaybeUninit<WireHello>, (), Welcome, ()>;
type LoanedFrame = RequestMutUninit<Ipc, MaybeUninit<WireFrame>, FrameHeader, WireReply, ()>;

/// Writes a hello into the memory that was loaned for it: its head, and as many primitives as it has.
pub(super) fn write_hello(
    mut loan: LoanedHello,
    from: &RawHello,
) -> RequestMut<Ipc, WireHello, (), Welcome, ()> {
    let to = loan.payload_mut().as_mut_ptr();
    // SAFETY: `to` is valid for writes of a whole `WireHello` and exclusively borrowed; its fields are reached
    // without a reference to any of it. A receiver reads no more primitives than the head counts. The others are
    // initialised all the same: the operating system zeroed the segment, and only integers were written to it since.
    unsafe {
        let head: *mut HelloHead = &raw mut (*to).head;
        head.write(*from.head);
        write_records((&raw mut (*to).primitives).cast(), PRIMITIVES_MAX, &from.primitives);
        loan.assume_init()
    }
}

/// Writes a frame into the memory that was loaned for it: `header`, as many records as the frame has, and its reason if there is
/// one.
pub(super) fn write_frame(
    mut loan: LoanedFrame,
    header: &FrameHeader,
    frame: &RawFrame,
) -> RequestMut<Ipc, WireFrame, FrameHeader, WireReply, ()> {
    *loan.user_header_mut() = *header;
    let to = loan.payload_mut().as_mut_ptr();
    // SAFETY: as in `write_hello`.
    unsafe {
        write_records((&raw mut (*to).records).cast(), OBSERVATIONS_MAX, &frame.records);
        if header.has_reason() {
            (&raw mut (*to).reason).write(frame.reason);
        }
        loan.assume_init()
    }
}

/// Writes at most `room` records.
///
/// # Safety
/// `to` is valid for writes of `room` records and does not overlap `from`.
unsafe fn write_records(to: *mut Record, room: usize, from: &[Record]) {
    // SAFETY: at most `room` records are written, by the caller's promise; `from` is valid for as many.
    unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), to, from.len().min(room)) }
}
