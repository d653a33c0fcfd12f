//! Descriptors of the transport's listeners, to be polled together with others.

use std::os::fd::BorrowedFd;

use iceoryx2::prelude::FileDescriptorBased;

/// The descriptor of this listener, as long as the listener is there.
pub(crate) fn borrowed(listener: &impl FileDescriptorBased) -> BorrowedFd<'_> {
    // SAFETY: the listener keeps owning the descriptor and has it open, and is borrowed as long as the
    // result is; nothing closes or reads it through the result.
    unsafe { BorrowedFd::borrow_raw(listener.file_descriptor().native_handle()) }
}
