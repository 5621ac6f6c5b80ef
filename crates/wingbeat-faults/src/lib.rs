//! System calls that fail on demand: a library that Linux loads before a program (`LD_PRELOAD`).
//!
//! Each writing, creation, renaming, removal or flush below the folder `WINGBEAT_FAULTS_UNDER`, and each start of a thread, is
//! a point; points are counted from 1. With `WINGBEAT_FAULTS_AT=N` point N fails, with `WINGBEAT_FAULTS_ON=1` all after it too, as on
//! a disk that stays full. The file `WINGBEAT_FAULTS_TOLD` holds what failed; without `AT`, the number of points.
//!
//! What is removed by a folder that is open, as the entries of whole folders are, is a point where that folder is watched.
//!
//! The calls take the place of those of the C library, with its signatures: that cannot be written without `unsafe`.
//! Nothing here uses what the standard library writes with: it would come back to the calls that are replaced.

#![cfg(target_os = "linux")]

use core::ffi::{CStr, c_char, c_int, c_long, c_uint, c_void};
use core::ptr;
use core::sync::atomic::{AtomicU64, Ordering};

/// Points so far.
static COUNT: AtomicU64 = AtomicU64::new(0);

/// The value of an environment variable.
fn variable(name: &'static CStr) -> Option<&'static CStr> {
    // SAFETY: the name ends with zero; the program does not change its environment.
    let value = unsafe { libc::getenv(name.as_ptr()) };
    // SAFETY: where it is not null it is a text that ends with zero.
    (!value.is_null()).then(|| unsafe { CStr::from_ptr(value) })
}

fn number(name: &'static CStr) -> u64 {
    let text = variable(name).map_or(&b""[..], CStr::to_bytes);
    text.iter().fold(0, |sum, digit| 10 * sum + u64::from(digit.wrapping_sub(b'0')))
}

/// Whether a path lies below the folder that is watched; one that is not absolute does.
fn watched(path: &[u8]) -> bool {
    let Some(folder) = variable(c"WINGBEAT_FAULTS_UNDER") else { return false };
    path.first().is_some_and(|first| *first != b'/') || path.starts_with(folder.to_bytes())
}

fn watched_path(path: *const c_char) -> bool {
    // SAFETY: the caller of a call with a path gives a text that ends with zero.
    !path.is_null() && watched(unsafe { CStr::from_ptr(path) }.to_bytes())
}

/// Whether a file below the folder is open as `descriptor`.
fn watched_file(descriptor: c_int) -> bool {
    let mut link = *b"/proc/self/fd/\0\0\0\0\0\0\0\0\0\0\0\0";
    let mut digits = [0; 10];
    let (mut rest, mut count) = (descriptor.max(0) as u32, 0);
    while count == 0 || rest > 0 {
        digits[count] = b'0' + (rest % 10) as u8;
        (rest, count) = (rest / 10, count + 1);
    }
    for (place, digit) in digits[..count].iter().rev().enumerate() {
        link[14 + place] = *digit;
    }
    let mut path = [0_u8; 4096];
    // SAFETY: the link ends with zero and the buffer has the length that is given.
    let read = unsafe {
        libc::syscall(libc::SYS_readlinkat, libc::AT_FDCWD, link.as_ptr(), path.as_mut_ptr(), path.len())
    };
    // What is no file, `pipe:[1]`, has no leading slash and is not watched.
    read > 0 && path[0] == b'/' && watched(&path[..read as usize])
}

/// Counts a point; whether it fails.
fn fails(what: &'static CStr) -> bool {
    let at = number(c"WINGBEAT_FAULTS_AT");
    let point = COUNT.fetch_add(1, Ordering::Relaxed) + 1;
    let fails = at > 0 && (point == at || (point > at && number(c"WINGBEAT_FAULTS_ON") > 0));
    if fails && point == at {
        tell(what.to_bytes());
    }
    if at == 0 {
        let mut text = [b'0'; 8];
        (0..8).fold(point, |rest, place| {
            text[7 - place] = b'0' + (rest % 10) as u8;
            rest / 10
        });
        tell(&text);
    }
    fails
}

/// Writes the file that tells the test.
fn tell(text: &[u8]) {
    let Some(file) = variable(c"WINGBEAT_FAULTS_TOLD") else { return };
    let flags = libc::O_WRONLY | libc::O_CREAT | libc::O_CLOEXEC;
    // SAFETY: the path ends with zero, the text has the length that is given, and the descriptor is the one that was opened.
    unsafe {
        let descriptor = libc::syscall(libc::SYS_openat, libc::AT_FDCWD, file.as_ptr(), flags, 0o644);
        libc::syscall(libc::SYS_pwrite64, descriptor, text.as_ptr(), text.len(), 0);
        libc::syscall(libc::SYS_close, descriptor);
    }
}

/// The outcome of a call that failed for this reason.
fn failed(reason: c_int) -> c_long {
    // SAFETY: the C library gives the place of the error of this thread.
    unsafe { *libc::__errno_location() = reason };
    -1
}

/// A call that takes the place of the one of its name: it fails with a reason where its point fails, else the kernel does it.
macro_rules! replaced {
    ($($name:ident($($argument:ident: $of:ty),*) -> $result:ty, $watched:expr, $reason:ident, $number:ident($($given:expr),*);)*) => {
        $(
            /// Replaces the call of the C library of this name.
            ///
            /// # Safety
            /// That of the call.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $of),*) -> $result {
                const NAME: &CStr = match CStr::from_bytes_with_nul(concat!(stringify!($name), "\0").as_bytes()) {
                    Ok(name) => name,
                    Err(_) => c"",
                };
                if $watched && fails(NAME) {
                    return failed(libc::$reason) as $result;
                }
                // SAFETY: the arguments are the caller's. `syscall` sets the error as the call does.
                unsafe { libc::syscall(libc::$number, $($given),*) as $result }
            }
        )*
    };
}

/// What opens a file to write it.
fn writes(flags: c_int) -> bool {
    flags & (libc::O_WRONLY | libc::O_RDWR | libc::O_CREAT) != 0
}

replaced! {
    write(file: c_int, bytes: *const c_void, count: usize) -> isize, watched_file(file), ENOSPC, SYS_write(file, bytes, count);
    pwrite64(file: c_int, bytes: *const c_void, count: usize, at: i64) -> isize, watched_file(file), ENOSPC, SYS_pwrite64(file, bytes, count, at);
    writev(file: c_int, parts: *const c_void, count: c_int) -> isize, watched_file(file), ENOSPC, SYS_writev(file, parts, count);
    ftruncate64(file: c_int, length: i64) -> c_int, watched_file(file), ENOSPC, SYS_ftruncate(file, length);
    fsync(file: c_int) -> c_int, watched_file(file), EIO, SYS_fsync(file);
    fdatasync(file: c_int) -> c_int, watched_file(file), EIO, SYS_fdatasync(file);
    open64(path: *const c_char, flags: c_int, mode: c_uint) -> c_int, writes(flags) && watched_path(path), ENOSPC,
        SYS_openat(libc::AT_FDCWD, path, flags, mode);
    mkdir(path: *const c_char, mode: c_uint) -> c_int, watched_path(path), ENOSPC, SYS_mkdirat(libc::AT_FDCWD, path, mode);
    rename(from: *const c_char, to: *const c_char) -> c_int, watched_path(to), EIO,
        SYS_renameat2(libc::AT_FDCWD, from, libc::AT_FDCWD, to, 0);
    unlink(path: *const c_char) -> c_int, watched_path(path), EIO, SYS_unlinkat(libc::AT_FDCWD, path, 0);
    unlinkat(folder: c_int, path: *const c_char, flags: c_int) -> c_int, watched_file(folder), EIO, SYS_unlinkat(folder, path, flags);
    rmdir(path: *const c_char) -> c_int, watched_path(path), EIO, SYS_unlinkat(libc::AT_FDCWD, path, libc::AT_REMOVEDIR);
}

type Start = unsafe extern "C" fn(*mut c_void, *const c_void, *const c_void, *mut c_void) -> c_int;

/// Replaces the start of a thread.
///
/// # Safety
/// That of the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pthread_create(
    thread: *mut c_void,
    attributes: *const c_void,
    start: *const c_void,
    given: *mut c_void,
) -> c_int {
    if variable(c"WINGBEAT_FAULTS_UNDER").is_some() && fails(c"pthread_create") {
        return libc::EAGAIN;
    }
    // SAFETY: the next library with this name is the C library, whose function has this signature.
    unsafe {
        let next = libc::dlsym(libc::RTLD_NEXT, c"pthread_create".as_ptr());
        if ptr::eq(next, ptr::null()) {
            return libc::EAGAIN;
        }
        core::mem::transmute::<*mut c_void, Start>(next)(thread, attributes, start, given)
    }
}
