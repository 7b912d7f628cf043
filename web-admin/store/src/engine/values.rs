//! Arguments of statements and values of rows. An argument is converted for the native driver when
//! its statement runs; a value is decoded by the native driver, without a copy.

use std::borrow::Cow;
use std::fmt;

use sqlx::encode::IsNull;
use sqlx::error::BoxDynError;
#[cfg(feature = "postgres")]
use sqlx::postgres::{PgArguments, PgTypeInfo, PgValue, PgValueRef, Postgres};
use sqlx::sqlite::{Sqlite, SqliteArguments, SqliteTypeInfo, SqliteValue, SqliteValueRef};
use sqlx::{Decode, Encode, Type};
use uuid::Uuid;

use super::driver::Engine;
use super::native;

/// Type of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum TypeInfo {
    /// Type of an argument.
    Given(ArgumentKind),
    /// Type of a SQLite value.
    Sqlite(SqliteTypeInfo),
    /// Type of a PostgreSQL value.
    #[cfg(feature = "postgres")]
    Postgres(PgTypeInfo),
}

impl From<SqliteTypeInfo> for TypeInfo {
    fn from(own: SqliteTypeInfo) -> Self {
        Self::Sqlite(own)
    }
}

#[cfg(feature = "postgres")]
impl From<PgTypeInfo> for TypeInfo {
    fn from(own: PgTypeInfo) -> Self {
        Self::Postgres(own)
    }
}

impl fmt::Display for TypeInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(sqlx::TypeInfo::name(self))
    }
}

impl sqlx::TypeInfo for TypeInfo {
    fn is_null(&self) -> bool {
        match self {
            Self::Given(_) => false,
            Self::Sqlite(own) => own.is_null(),
            #[cfg(feature = "postgres")]
            Self::Postgres(own) => own.is_null(),
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Given(kind) => kind.name(),
            Self::Sqlite(own) => own.name(),
            #[cfg(feature = "postgres")]
            Self::Postgres(own) => own.name(),
        }
    }
}

/// A value borrowed from its row.
pub enum ValueRef<'r> {
    /// A SQLite value.
    Sqlite(SqliteValueRef<'r>),
    /// A PostgreSQL value.
    #[cfg(feature = "postgres")]
    Postgres(PgValueRef<'r>),
}

impl<'r> From<SqliteValueRef<'r>> for ValueRef<'r> {
    fn from(own: SqliteValueRef<'r>) -> Self {
        Self::Sqlite(own)
    }
}

#[cfg(feature = "postgres")]
impl<'r> From<PgValueRef<'r>> for ValueRef<'r> {
    fn from(own: PgValueRef<'r>) -> Self {
        Self::Postgres(own)
    }
}

impl<'r> sqlx::ValueRef<'r> for ValueRef<'r> {
    type Database = Engine;

    fn to_owned(&self) -> AnswerValue {
        match self {
            Self::Sqlite(own) => AnswerValue::Sqlite(sqlx::ValueRef::to_owned(own)),
            #[cfg(feature = "postgres")]
            Self::Postgres(own) => AnswerValue::Postgres(sqlx::ValueRef::to_owned(own)),
        }
    }

    fn type_info(&self) -> Cow<'_, TypeInfo> {
        native!(Self, self, own => Cow::Owned(own.type_info().into_owned().into()))
    }

    fn is_null(&self) -> bool {
        native!(Self, self, own => own.is_null())
    }
}

/// An owned value.
pub enum AnswerValue {
    /// A SQLite value.
    Sqlite(SqliteValue),
    /// A PostgreSQL value.
    #[cfg(feature = "postgres")]
    Postgres(PgValue),
}

impl sqlx::Value for AnswerValue {
    type Database = Engine;

    fn as_ref(&self) -> ValueRef<'_> {
        native!(Self, self, own => own.as_ref().into())
    }

    fn type_info(&self) -> Cow<'_, TypeInfo> {
        native!(Self, self, own => Cow::Owned(own.type_info().into_owned().into()))
    }

    fn is_null(&self) -> bool {
        native!(Self, self, own => own.is_null())
    }
}

/// Arguments of a statement, in order.
#[derive(Debug, Default)]
pub struct Arguments(Vec<Argument>);

impl sqlx::Arguments for Arguments {
    type Database = Engine;

    fn reserve(&mut self, additional: usize, _size: usize) {
        self.0.reserve(additional);
    }

    fn add<'t, T: Encode<'t, Engine> + Type<Engine>>(&mut self, value: T) -> Result<(), BoxDynError> {
        if let IsNull::Yes = value.encode(&mut self.0)?
            && let TypeInfo::Given(kind) = T::type_info()
        {
            self.0.push(Argument::Null(kind));
        }
        Ok(())
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    fn format_placeholder<W: fmt::Write>(&self, writer: &mut W) -> fmt::Result {
        write!(writer, "${}", self.0.len())
    }
}

sqlx_core::impl_into_arguments_for_arguments!(Arguments);
sqlx_core::impl_encode_for_option!(Engine);

/// Implements decoding with the native decoder of each engine.
macro_rules! read_natively {
    ($($kind:ident: $read:ty),+ $(,)?) => {$(
        impl sqlx::Type<$crate::engine::Engine> for $read {
            fn type_info() -> $crate::engine::TypeInfo {
                $crate::engine::TypeInfo::Given($crate::engine::ArgumentKind::$kind)
            }

            fn compatible(found: &$crate::engine::TypeInfo) -> bool {
                match found {
                    $crate::engine::TypeInfo::Given(kind) => *kind == $crate::engine::ArgumentKind::$kind,
                    $crate::engine::TypeInfo::Sqlite(own) => <Self as sqlx::Type<sqlx::Sqlite>>::compatible(own),
                    #[cfg(feature = "postgres")]
                    $crate::engine::TypeInfo::Postgres(own) => <Self as sqlx::Type<sqlx::Postgres>>::compatible(own),
                }
            }
        }

        impl<'r> sqlx::Decode<'r, $crate::engine::Engine> for $read {
            fn decode(value: $crate::engine::ValueRef<'r>) -> std::result::Result<Self, sqlx::error::BoxDynError> {
                match value {
                    $crate::engine::ValueRef::Sqlite(own) => <Self as sqlx::Decode<'r, sqlx::Sqlite>>::decode(own),
                    #[cfg(feature = "postgres")]
                    $crate::engine::ValueRef::Postgres(own) => <Self as sqlx::Decode<'r, sqlx::Postgres>>::decode(own),
                }
            }
        }
    )+};
}

pub(crate) use read_natively;

/// Defines the argument types, all supported by both engines.
macro_rules! arguments {
    ($($kind:ident: $given:ty),+ $(,)?) => {
        /// Type of an argument.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum ArgumentKind {
            $(#[doc = stringify!($given)] $kind),+
        }

        impl ArgumentKind {
            const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => stringify!($given)),+
                }
            }
        }

        /// An argument of a statement.
        #[derive(Clone, Debug)]
        pub enum Argument {
            /// NULL with its type, which PostgreSQL needs.
            Null(ArgumentKind),
            $(#[doc = stringify!($given)] $kind($given)),+
        }

        $(
            impl Encode<'_, Engine> for $given {
                fn encode(self, to: &mut Vec<Argument>) -> Result<IsNull, BoxDynError> {
                    to.push(Argument::$kind(self));
                    Ok(IsNull::No)
                }

                fn encode_by_ref(&self, to: &mut Vec<Argument>) -> Result<IsNull, BoxDynError> {
                    <Self as Encode<'_, Engine>>::encode(Clone::clone(self), to)
                }
            }
        )+

        impl Arguments {
            fn give<A: sqlx::Arguments>(self) -> Result<A, BoxDynError>
            where
                $($given: for<'q> Encode<'q, A::Database> + Type<A::Database>,
                  Option<$given>: for<'q> Encode<'q, A::Database> + Type<A::Database>,)+
            {
                let mut given = A::default();
                given.reserve(self.0.len(), 0);
                for argument in self.0 {
                    match argument {
                        $(Argument::$kind(value) => given.add(value)?,
                          Argument::Null(ArgumentKind::$kind) => given.add(None::<$given>)?,)+
                    }
                }
                Ok(given)
            }
        }

        read_natively!($($kind: $given),+);
    };
}

arguments! {
    Truth: bool,
    Short: i32,
    Whole: i64,
    Real: f64,
    Text: String,
    Bytes: Vec<u8>,
    Id: Uuid,
}

impl TryFrom<Arguments> for SqliteArguments {
    type Error = BoxDynError;

    fn try_from(given: Arguments) -> Result<Self, BoxDynError> {
        given.give()
    }
}

#[cfg(feature = "postgres")]
impl TryFrom<Arguments> for PgArguments {
    type Error = BoxDynError;

    fn try_from(given: Arguments) -> Result<Self, BoxDynError> {
        given.give()
    }
}

impl Encode<'_, Engine> for &str {
    fn encode_by_ref(&self, to: &mut Vec<Argument>) -> Result<IsNull, BoxDynError> {
        <String as Encode<'_, Engine>>::encode((*self).to_owned(), to)
    }
}

impl Encode<'_, Engine> for Cow<'_, str> {
    fn encode_by_ref(&self, to: &mut Vec<Argument>) -> Result<IsNull, BoxDynError> {
        <String as Encode<'_, Engine>>::encode(self.clone().into_owned(), to)
    }
}

impl Encode<'_, Engine> for &[u8] {
    fn encode_by_ref(&self, to: &mut Vec<Argument>) -> Result<IsNull, BoxDynError> {
        <Vec<u8> as Encode<'_, Engine>>::encode(self.to_vec(), to)
    }
}

/// Implements decoding of borrowed values, without a copy.
macro_rules! read_borrowed {
    ($($whole:ty: $borrowed:ty),+) => {$(
        impl Type<Engine> for $borrowed {
            fn type_info() -> TypeInfo {
                <$whole as Type<Engine>>::type_info()
            }

            fn compatible(found: &TypeInfo) -> bool {
                <$whole as Type<Engine>>::compatible(found)
            }
        }

        impl<'r> Decode<'r, Engine> for &'r $borrowed {
            fn decode(value: ValueRef<'r>) -> Result<Self, BoxDynError> {
                match value {
                    ValueRef::Sqlite(own) => <Self as Decode<'r, Sqlite>>::decode(own),
                    #[cfg(feature = "postgres")]
                    ValueRef::Postgres(own) => <Self as Decode<'r, Postgres>>::decode(own),
                }
            }
        }
    )+};
}

read_borrowed!(String: str, Vec<u8>: [u8]);

// Enumerations stored as text.
read_natively! {
    Text: model::FactorRule,
    Text: model::Needed,
    Text: model::Role,
    Text: model::Uncounted,
    Text: model::training::comment::CommentKind,
    Text: model::training::risk::RiskRule,
    Text: model::training::support_note::SupportKind,
    Text: model::people::directory::AccountState,
    Text: model::letters::mail::MailKind,
    Text: model::training::membership::MembershipAct,
    Text: model::letters::notice::NoticeKind,
    Text: model::scoring::regrading::RegradingOutcome,
    Text: model::scoring::regrading::RegradingState,
    Text: model::surveys::Identity,
    Text: model::surveys::ResponseState,
}
