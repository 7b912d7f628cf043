-- Tries to sign in with addresses that nobody has, by the hour, until the audit log is told of them.
CREATE TABLE unknown_sign_ins (
    begins_at INTEGER PRIMARY KEY NOT NULL, -- of the hour
    tries INTEGER NOT NULL CHECK (tries > 0)
) STRICT;
