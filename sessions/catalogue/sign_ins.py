"""Verbs of sign-ins: the server remembers each, so that ending one ends it everywhere."""

from __future__ import annotations

from sqlalchemy import delete, select, update

from sessions.catalogue.clinic_records import SignIn
from sessions.catalogue.clinic_tables import SignInRow
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.rows import value_of


class SignIns(Ledger):
    """Sign-ins by the digest of their secret."""

    def add_sign_in(self, digest: str, user: str) -> SignIn:
        """Remember a new sign-in; its times are given here."""
        with self._writing() as session:
            now_ns = self._clock_ns()
            row = SignInRow(digest, user, now_ns, now_ns, 0)
            session.add(row)
            session.flush()
            return value_of(SignIn, row)

    def sign_in(self, digest: str) -> SignIn | None:
        """The sign-in of that digest, ended ones among them; None where there is none."""
        with self._reading() as session:
            row = session.get(SignInRow, digest)
            return None if row is None else value_of(SignIn, row)

    def sign_ins(self, user: str) -> tuple[SignIn, ...]:
        """Sign-ins of a user that hold, newest first."""
        with self._reading() as session:
            query = select(SignInRow).where(SignInRow.user == user, SignInRow.ended_utc_ns == 0)
            rows = session.scalars(query.order_by(SignInRow.issued_utc_ns.desc()))
            return tuple(value_of(SignIn, row) for row in rows)

    def see_sign_in(self, digest: str) -> None:
        """Note that a sign-in was used now."""
        with self._writing() as session:
            at = update(SignInRow).where(SignInRow.id == digest, SignInRow.ended_utc_ns == 0)
            session.execute(at.values(seen_utc_ns=self._clock_ns()))

    def end_sign_ins(self, user: str, digest: str = "") -> None:
        """End one sign-in of a user, or, without a digest, all of them."""
        with self._writing() as session:
            held = update(SignInRow).where(SignInRow.user == user, SignInRow.ended_utc_ns == 0)
            if digest:
                held = held.where(SignInRow.id == digest)
            session.execute(held.values(ended_utc_ns=self._clock_ns()))

    def forget_sign_ins(self, before_utc_ns: int) -> None:
        """Delete those that were issued before a time."""
        with self._writing() as session:
            session.execute(delete(SignInRow).where(SignInRow.issued_utc_ns < before_utc_ns))
