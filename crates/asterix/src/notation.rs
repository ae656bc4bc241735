//! The notation of the tables: an element a line, as in the document.
//!
//! ```text
//! items! {
//!     I010 "010" "Data Source Identifier" {
//!         SAC: 8,
//!         SIC: 8,
//!     }
//!     I015 "015" "Service Identification" (8)
//! }
//! ```
//!
//! [`items!`] defines a constant per item: name of the constant, the item's number, title and layout. A preceding
//! `sub` makes a subitem for a compound item; `parts` before a constant and a group makes parts shared by several
//! items. A layout is one of
//!
//! - `(16 signed(0.5, "m"))`: an element with bits and content; without content it is [`RAW`](crate::table::RAW);
//! - `{ NAME: 8 NUMBER, … }`: a group of elements. `_: 3` are spare bits, `NAME: { … }` elements under a common name; a
//!   name that is no Rust identifier stands in quotation marks;
//! - `(PARTS)`: a group that several items have alike;
//! - `[{ … } PART { … }]`: an extended item, of groups and constants;
//! - `(repetitive LAYOUT)`, `(repetitive_fx LAYOUT)`;
//! - `(compound [NAME "Title" LAYOUT, CONSTANT, _, …])`, where `_` stands for a bit without meaning;
//! - `(= …)`: an expression.
//!
//! [`profile!`] lists the items by field reference number, `_` for an unused number. [`editions!`] defines a
//! category: the name of the list of editions, number, title, document and the items with the time of day; then a
//! line per edition, oldest first: its name, number and profile.

macro_rules! items {
    () => {};
    (sub $constant:ident $name:literal $title:literal $layout:tt $($rest:tt)*) => {
        const $constant: Option<Item> = subitem($name, $title, layout!($layout));
        items! { $($rest)* }
    };
    (parts $constant:ident { $($parts:tt)* } $($rest:tt)*) => {
        const $constant: &[Part] = parts!($($parts)*);
        items! { $($rest)* }
    };
    ($constant:ident $name:literal $title:literal $layout:tt $($rest:tt)*) => {
        const $constant: Item = Item::new($name, $title, layout!($layout));
        items! { $($rest)* }
    };
}

macro_rules! layout {
    ({ $($parts:tt)* }) => { Layout::Group(parts!($($parts)*)) };
    ([ $($part:tt)* ]) => { Layout::Extended(&[$(extension!($part)),*]) };
    ((repetitive $layout:tt)) => { Layout::Repetitive(&layout!($layout)) };
    ((repetitive_fx $layout:tt)) => { Layout::RepetitiveFx(&layout!($layout)) };
    ((compound [ $($name:tt $($title:literal $layout:tt)?),* $(,)? ])) => {
        Layout::Compound(&[$(subitem_of!($name $($title $layout)?)),*])
    };
    ((= $layout:expr)) => { $layout };
    (($parts:ident)) => { Layout::Group($parts) };
    (($bits:literal)) => { Layout::Element($bits, RAW) };
    (($bits:literal $content:expr)) => { Layout::Element($bits, $content) };
}

macro_rules! profile {
    ($($item:tt),* $(,)?) => { [$(entry!($item)),*] };
}

macro_rules! entry {
    (_) => {
        None
    };
    ($constant:ident) => {
        Some($constant)
    };
}

macro_rules! extension {
    ({ $($parts:tt)* }) => { parts!($($parts)*) };
    ($constant:ident) => { $constant };
}

macro_rules! subitem_of {
    (_) => {
        None
    };
    ((= $subitem:expr)) => {
        $subitem
    };
    ($constant:ident) => {
        $constant
    };
    ($name:tt $title:literal $layout:tt) => {
        subitem(name!($name), $title, layout!($layout))
    };
}

macro_rules! parts {
    ($($name:tt : $bits:tt $($content:expr)?),* $(,)?) => { &[$(part!($name $bits $($content)?)),*] };
}

macro_rules! part {
    (_ $bits:literal) => { spare($bits) };
    ($name:tt $bits:literal) => { element(name!($name), $bits, RAW) };
    ($name:tt $bits:literal $content:expr) => { element(name!($name), $bits, $content) };
    ($name:tt { $($parts:tt)* }) => { group(name!($name), parts!($($parts)*)) };
}

macro_rules! name {
    ($name:ident) => {
        stringify!($name)
    };
    ($name:literal) => {
        $name
    };
}

macro_rules! editions {
    (
        $all:ident $number:literal $title:literal $document:literal $times:tt
        $($edition:ident $major:literal $minor:literal $items:expr;)+
    ) => {
        $(
            #[doc = concat!($title, ", ed ", $major, ".", $minor, ".")]
            pub static $edition: Category =
                Category::new($number, Edition::new($major, $minor), [$title, $document], $items, &$times);
        )+
        #[doc = concat!($title, ": the editions of one layout, the oldest first.")]
        pub static $all: &[&Category] = &[$(&$edition),+];
        const _: () = crate::registry::assert_registered($all);
    };
}
