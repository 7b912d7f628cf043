-- Tries to sign in with addresses that nobody has, by the hour, until the audit log is told of them.
CREATE TABLE unknown_sign_ins (
    begins_at BIGINT PRIMARY KEY, -- of the hour
    tries BIGINT NOT NULL CHECK (tries > 0)
);
