-- What the command that makes backups has come to, for those who look after a school. The file itself lies where the command puts it.
CREATE TABLE backups (
    id BLOB PRIMARY KEY CHECK (length(id) = 16),
    made_at INTEGER NOT NULL,
    file_name TEXT NOT NULL,
    bytes INTEGER CHECK (bytes > 0),
    recordings INTEGER CHECK (recordings >= 0),
    keys_sealed INTEGER NOT NULL CHECK (keys_sealed IN (0, 1)),
    -- Why it was not made; what was made was read back and is whole.
    error TEXT,
    CHECK ((error IS NULL) = (bytes IS NOT NULL)),
    CHECK ((error IS NULL) = (recordings IS NOT NULL))
) STRICT;
CREATE INDEX backups_by_time ON backups (made_at, id);
