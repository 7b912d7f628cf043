-- A school's logo: its pixels alone, in a file that the service has written itself.
CREATE TABLE school_logos (
    school_id BLOB PRIMARY KEY NOT NULL REFERENCES schools (id),
    media_type TEXT NOT NULL CHECK (media_type IN ('image/png', 'image/jpeg')),
    width INTEGER NOT NULL CHECK (width > 0),
    height INTEGER NOT NULL CHECK (height > 0),
    bytes BLOB NOT NULL,
    -- The first half of its SHA-256, hexadecimal: its address changes with it.
    version TEXT NOT NULL CHECK (length(version) = 32)
) STRICT;
