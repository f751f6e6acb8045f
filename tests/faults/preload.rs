//! The library that is preloaded into the program: what it can do, and what it wrote down.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A kind of system call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Call {
    OpenToRead,
    /// Also of what is made.
    OpenToWrite,
    Write,
    /// Of a file or a folder.
    Sync,
    Rename,
    /// Giving a file one more name.
    Link,
    Lock,
    Truncate,
    /// Making a folder.
    Mkdir,
    Remove,
}

impl Call {
    const ALL: [Self; 10] = [
        Self::OpenToRead,
        Self::OpenToWrite,
        Self::Write,
        Self::Sync,
        Self::Rename,
        Self::Link,
        Self::Lock,
        Self::Truncate,
        Self::Mkdir,
        Self::Remove,
    ];

    /// What the library calls it.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::OpenToRead => "open-read",
            Self::OpenToWrite => "open-write",
            Self::Write => "write",
            Self::Sync => "sync",
            Self::Rename => "rename",
            Self::Link => "link",
            Self::Lock => "lock",
            Self::Truncate => "truncate",
            Self::Mkdir => "mkdir",
            Self::Remove => "remove",
        }
    }

    /// What can happen in it.
    pub(crate) fn faults(self) -> impl Iterator<Item = Fault> {
        Fault::ALL.into_iter().filter(move |fault| match fault {
            Fault::Short | Fault::Full | Fault::Torn => self == Self::Write,
            Fault::NoCall => matches!(self, Self::Lock | Self::Sync),
            Fault::NotSupported => matches!(self, Self::Lock | Self::Sync | Self::Link),
            Fault::NoLocks => self == Self::Lock,
            Fault::OtherDevice => self == Self::Rename,
            _ => true,
        })
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OpenToRead => "open to read",
            Self::OpenToWrite => "open to write",
            _ => self.name(),
        })
    }
}

/// What happens in a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fault {
    NoSpace,
    Io,
    Invalid,
    NoCall,
    NoLocks,
    NotSupported,
    OtherDevice,
    /// Half is written.
    Short,
    /// Half is written, and from then on nothing more.
    Full,
    /// Half is written, then the process is killed.
    Torn,
    KillBefore,
    KillAfter,
}

impl Fault {
    const ALL: [Self; 12] = [
        Self::NoSpace,
        Self::Io,
        Self::Invalid,
        Self::NoCall,
        Self::NoLocks,
        Self::NotSupported,
        Self::OtherDevice,
        Self::Short,
        Self::Full,
        Self::Torn,
        Self::KillBefore,
        Self::KillAfter,
    ];

    /// What the library calls it.
    fn action(self) -> &'static str {
        match self {
            Self::NoSpace => "28",
            Self::Io => "5",
            Self::Invalid => "22",
            Self::NoCall => "38",
            Self::NoLocks => "37",
            Self::NotSupported => "95",
            Self::OtherDevice => "18",
            Self::Short => "short",
            Self::Full => "full",
            Self::Torn => "torn",
            Self::KillBefore => "before",
            Self::KillAfter => "after",
        }
    }

    /// Whether the file system has no such call.
    pub(crate) fn is_missing(self, call: Call) -> bool {
        call == Call::Lock && matches!(self, Self::NoCall | Self::NoLocks | Self::NotSupported)
    }

    /// Which later calls fail as well: a service that is missing is missing for all, and a file
    /// that cannot be opened cannot be opened again.
    fn lasts(self, call: Call) -> Option<&'static str> {
        match (call, self) {
            _ if self.is_missing(call) => Some("call"),
            (Call::OpenToRead, Self::NoSpace | Self::Io | Self::Invalid) => Some("file"),
            _ => None,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoSpace => "ENOSPC",
            Self::Io => "EIO",
            Self::Invalid => "EINVAL",
            Self::NoCall => "ENOSYS",
            Self::NoLocks => "ENOLCK",
            Self::NotSupported => "EOPNOTSUPP",
            Self::OtherDevice => "EXDEV",
            Self::Short => "half written",
            Self::Full => "half written, disk full from then on",
            Self::Torn => "killed half way",
            Self::KillBefore => "killed before",
            Self::KillAfter => "killed after",
        })
    }
}

/// One fault in one call of one process.
#[derive(Clone, Debug)]
pub(crate) struct Injection {
    /// Subcommand of the process.
    pub(crate) command: &'static str,
    pub(crate) call: Call,
    /// The first call of this kind is 1.
    pub(crate) at: usize,
    pub(crate) fault: Fault,
}

impl Injection {
    /// The environment that asks the library for it.
    pub(crate) fn environment(&self) -> Vec<(&'static str, String)> {
        let Self { command, call, at, fault } = self;
        let mut environment = vec![
            ("FAULTS_COMMAND", (*command).to_owned()),
            ("FAULTS_CALL", call.name().to_owned()),
            ("FAULTS_AT", at.to_string()),
            ("FAULTS_ACTION", fault.action().to_owned()),
        ];
        environment.extend(fault.lasts(*call).map(|what| ("FAULTS_LASTING", what.to_owned())));
        environment
    }
}

/// A call that was made.
#[derive(Clone, Debug)]
pub(crate) struct Noted {
    pub(crate) command: String,
    pub(crate) call: Call,
    pub(crate) at: usize,
    pub(crate) is_hit: bool,
    pub(crate) has_succeeded: bool,
    /// Below the folder that is watched, with a slash in front; empty for the folder itself.
    pub(crate) path: String,
}

impl Noted {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.splitn(6, ' ');
        let command = words.next()?.to_owned();
        let name = words.next()?;
        let at = words.next()?.parse().ok()?;
        let is_hit = words.next()? == "1";
        let error = words.next()?;
        let call = Call::ALL.into_iter().find(|call| call.name() == name)?;
        let path = words.next()?.to_owned();
        Some(Self { command, call, at, is_hit, has_succeeded: error == "0", path })
    }
}

/// The calls in a file that the library wrote.
pub(crate) fn read_log(path: &Path) -> Vec<Noted> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().map(|line| Noted::parse(line).unwrap_or_else(|| panic!("{line}"))).collect()
}

/// Compiles the library; `None` where there is no C compiler, or another C library than it is for.
pub(crate) fn library() -> Option<PathBuf> {
    if !cfg!(all(target_os = "linux", target_env = "gnu")) {
        return None;
    }
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/faults/inject.c");
    let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join("inject.so");
    let mut compile = Command::new("cc");
    compile.args(["-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC", "-o"]);
    let compiled = compile.arg(&library).args([source, "-ldl"]).output().ok()?;
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    Some(library)
}
