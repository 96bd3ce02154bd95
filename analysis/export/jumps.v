(* ---- A solution of d x' = A x: x_i = sum_k (A/d)^k x(0) t^k/k!, one by one ---- *)

Require Import Ranalysis5.

Fixpoint total_size (s : list R) : R := match s with x :: s' => Rabs x + total_size s' | [] => 0 end.
Fixpoint whole_size (A : list (list Z)) : Z := match A with r :: A' => (row_size r + whole_size A')%Z | [] => 0%Z end.
Definition applied (d : Z) (A : list (list Z)) (s : list R) : list R := map (fun y => y / IZR d) (at_ A s).
Fixpoint powers_of (d : Z) (A : list (list Z)) (s : list R) (k : nat) : list R :=
  match k with O => s | S j => applied d A (powers_of d A s j) end.

Lemma total_nonneg : forall s, 0 <= total_size s.
Proof. induction s as [|x s IH]; cbn [total_size]; [lra|]; pose proof (Rabs_pos x); lra. Qed.
Lemma nth_total : forall s i, Rabs (nth i s 0) <= total_size s.
Proof.
  induction s as [|x s IH]; intros [|i]; cbn [nth total_size]; try (rewrite Rabs_R0; lra).
  - pose proof (total_nonneg s); lra.
  - specialize (IH i); pose proof (Rabs_pos x); lra.
Qed.
Lemma dot_total : forall r s, Rabs (dot r s) <= IZR (row_size r) * total_size s.
Proof.
  induction r as [|a r IH]; intros [|x s]; cbn [dot row_size total_size]; try (rewrite Rabs_R0; lra).
  apply Rle_trans with (1 := Rabs_triang _ _); specialize (IH s); rewrite plus_IZR, abs_IZR, Rabs_mult.
  pose proof (Rmult_le_pos _ _ (Rabs_pos (IZR a)) (total_nonneg s)).
  pose proof (Rmult_le_pos _ _ (row_size_nonneg r) (Rabs_pos x)); lra.
Qed.
Lemma applied_total : forall d A s, (0 < d)%Z -> total_size (applied d A s) <= IZR (whole_size A) * total_size s.
Proof.
  intros d A s dpos; assert (D : 1 <= IZR d) by (apply IZR_le; lia); unfold applied, at_; rewrite map_map.
  induction A as [|r A IH]; cbn [map total_size whole_size]; [pose proof (total_nonneg s); lra|].
  rewrite plus_IZR; pose proof (dot_total r s) as B; unfold Rdiv; rewrite Rabs_mult.
  assert (I : Rabs (/ IZR d) <= 1).
  { rewrite Rabs_right by (apply Rle_ge; left; apply Rinv_0_lt_compat; lra).
    rewrite <- Rinv_1; apply Rinv_le_contravar; lra. }
  pose proof (Rabs_pos (dot r s)); pose proof (Rabs_pos (/ IZR d)).
  assert (Rabs (dot r s) * Rabs (/ IZR d) <= Rabs (dot r s) * 1) by (apply Rmult_le_compat_l; assumption).
  unfold Rdiv in IH; lra.
Qed.
Lemma whole_size_nonneg : forall A, 0 <= IZR (whole_size A).
Proof. induction A as [|r A IH]; cbn [whole_size]; [lra|]; rewrite plus_IZR; pose proof (row_size_nonneg r); lra. Qed.
Lemma powers_total : forall d A s k, (0 < d)%Z -> total_size (powers_of d A s k) <= total_size s * IZR (whole_size A) ^ k.
Proof.
  intros d A s k dpos; induction k as [|k IH]; cbn [powers_of pow]; [lra|].
  apply Rle_trans with (1 := applied_total d A _ dpos).
  pose proof (Rmult_le_compat_l _ _ _ (whole_size_nonneg A) IH); lra.
Qed.
Lemma powers_later : forall d A s k, powers_of d A s (S k) = powers_of d A (applied d A s) k.
Proof. intros d A s; induction k as [|k IH]; [reflexivity|]; cbn [powers_of] in *; now rewrite IH. Qed.

Definition part_of (d : Z) (A : list (list Z)) (s : list R) (i k : nat) (t : R) : R :=
  nth i (powers_of d A s k) 0 * (/ INR (fact k) * t ^ k).
Lemma normally : forall d A s i, (0 < d)%Z -> CVN_R (part_of d A s i).
Proof.
  intros d A s i dpos rho; set (r := IZR (whole_size A)); set (C := total_size s).
  assert (rp : 0 <= r) by apply whole_size_nonneg; assert (Cp : 0 <= C) by apply total_nonneg.
  assert (P : forall k, 0 <= C * (/ INR (fact k) * (r * rho) ^ k)).
  { intro k; apply Rmult_le_pos; [exact Cp|]; apply Rmult_le_pos; [left; apply Rinv_0_lt_compat, INR_fact_lt_0|].
    apply pow_le, Rmult_le_pos; [exact rp|left; apply cond_pos]. }
  exists (fun k => C * (/ INR (fact k) * (r * rho) ^ k)).
  destruct (exist_exp (r * rho)) as [l H]; exists (C * l); split.
  - intros eps epos; destruct (CV_mult (fun _ => C) (fun N => sum_f_R0 (fun k => / INR (fact k) * (r * rho) ^ k) N) C l) with (eps := eps)
      as [N HN]; [|exact H|exact epos|].
    + intros e E; exists O; intros k _; unfold R_dist; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; exact E.
    + exists N; intros k K; specialize (HN k K).
      replace (sum_f_R0 (fun k => Rabs (C * (/ INR (fact k) * (r * rho) ^ k))) k)
        with (C * sum_f_R0 (fun k => / INR (fact k) * (r * rho) ^ k) k); [exact HN|].
      rewrite scal_sum; apply sum_eq; intros j _; rewrite Rabs_right by (apply Rle_ge, P); ring.
  - intros k t T; unfold Boule in T; rewrite Rminus_0_r in T; unfold part_of.
    rewrite !Rabs_mult, (Rabs_right (/ INR (fact k))) by (apply Rle_ge; left; apply Rinv_0_lt_compat, INR_fact_lt_0).
    rewrite <- RPow_abs, Rpow_mult_distr.
    apply Rle_trans with (C * r ^ k * (/ INR (fact k) * rho ^ k)); [|right; ring].
    apply Rmult_le_compat.
    + apply Rabs_pos.
    + apply Rmult_le_pos; [left; apply Rinv_0_lt_compat, INR_fact_lt_0|apply pow_le, Rabs_pos].
    + apply Rle_trans with (1 := nth_total _ i); now apply powers_total.
    + apply Rmult_le_compat_l; [left; apply Rinv_0_lt_compat, INR_fact_lt_0|].
      apply pow_incr; split; [apply Rabs_pos|lra].
Qed.
Definition sol (d : Z) (dpos : (0 < d)%Z) (A : list (list Z)) (s : list R) (i : nat) : R -> R :=
  SFL (part_of d A s i) (CVN_R_CVS _ (normally d A s i dpos)).

Lemma sol_limit : forall d dpos A s i t, Un_cv (fun N => SP (part_of d A s i) N t) (sol d dpos A s i t).
Proof. intros; unfold sol, SFL; now destruct (CVN_R_CVS _ (normally d A s i dpos) t). Qed.
Lemma sol_start : forall d dpos A s i, sol d dpos A s i 0 = nth i s 0.
Proof.
  intros d dpos A s i; apply (UL_sequence _ _ _ (sol_limit d dpos A s i 0)); intros eps epos; exists O; intros N _.
  assert (E : SP (part_of d A s i) N 0 = nth i s 0).
  { unfold SP; induction N as [|N IH]; cbn [sum_f_R0]; [unfold part_of; cbn; field|].
    rewrite IH; unfold part_of; rewrite pow_i by lia; ring. }
  rewrite E; unfold R_dist; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; exact epos.
Qed.
Lemma sol_derivative : forall d dpos A s i t, derivable_pt_lim (sol d dpos A s i) t (sol d dpos A (applied d A s) i t).
Proof.
  intros d dpos A s i t; assert (rp : 0 < Rabs t + 1) by (pose proof (Rabs_pos t); lra).
  set (r := mkposreal _ rp); set (s1 := applied d A s).
  assert (next : forall k u, derivable_pt_lim (part_of d A s i (S k)) u (part_of d A s1 i k u)).
  { intros k u; unfold part_of; rewrite (powers_later d A s k); fold s1; set (c := nth i (powers_of d A s1 k) 0).
    apply (derivable_same (fun t => c * (/ INR (fact (S k)) * t ^ S k)) _ u (c * (/ INR (fact (S k)) * (INR (S k) * u ^ k))));
      [reflexivity| |].
    - rewrite fact_simpl, mult_INR; field; split; [apply INR_fact_neq_0|apply not_0_INR; lia].
    - apply (derivable_pt_lim_scal (fun t => / INR (fact (S k)) * t ^ S k)), (derivable_pt_lim_scal (fun t => t ^ S k)).
      exact (derivable_pt_lim_pow u (S k)). }
  apply (derivable_pt_lim_CVU (fun N => SP (part_of d A s i) (S N)) (fun N => SP (part_of d A s1 i) N)
    (sol d dpos A s i) (sol d dpos A s1 i) t 0 r).
  - unfold Boule; rewrite Rminus_0_r; cbn; lra.
  - intros u N _; unfold SP; induction N as [|N IH].
    + cbn [sum_f_R0].
      apply (derivable_same (fun t => part_of d A s i 0 t + part_of d A s i 1 t) _ u (0 + part_of d A s1 i 0 u));
        [reflexivity|ring|].
      apply (derivable_pt_lim_plus (part_of d A s i 0) (part_of d A s i 1)); [|apply next].
      unfold part_of; cbn [fact pow]; apply derivable_pt_lim_const.
    + apply (derivable_pt_lim_plus (fun t => sum_f_R0 (fun k => part_of d A s i k t) (S N)) (part_of d A s i (S (S N))));
        [exact IH|apply next].
  - intros u _ eps epos; destruct (sol_limit d dpos A s i u eps epos) as [N H]; exists N; intros k K; apply H; lia.
  - apply (CVN_CVU (part_of d A s1 i) (CVN_R_CVS _ (normally d A s1 i dpos)) r (normally d A s1 i dpos r)).
  - intros u _; apply SFL_continuity; [apply normally; exact dpos|].
    intros k v; unfold part_of; apply continuity_pt_scal, continuity_pt_scal, derivable_continuous_pt, derivable_pt_pow.
Qed.

Lemma powers_length : forall d A s k, length s = length A -> length (powers_of d A s k) = length A.
Proof. intros d A s [|k] L; cbn [powers_of]; [exact L|]; unfold applied, at_; now rewrite !map_length. Qed.
Lemma SP_sum : forall (y z : nat -> R) a t N,
  sum_f_R0 (fun k => (a * y k + z k) * (/ INR (fact k) * t ^ k)) N
  = a * sum_f_R0 (fun k => y k * (/ INR (fact k) * t ^ k)) N + sum_f_R0 (fun k => z k * (/ INR (fact k) * t ^ k)) N.
Proof. intros y z a t; induction N as [|N IH]; cbn [sum_f_R0]; [ring|]; rewrite IH; ring. Qed.
Lemma same_limit : forall f g l, (forall k : nat, f k = g k) -> Un_cv f l -> Un_cv g l.
Proof. intros f g l E L eps pos; destruct (L eps pos) as [T H]; exists T; intros t Ht; rewrite <- E; auto. Qed.
Lemma dot_limit : forall (y : nat -> nat -> R) l t row a m,
  (forall i, Un_cv (fun N => sum_f_R0 (fun k => y i k * (/ INR (fact k) * t ^ k)) N) (l i)) ->
  Un_cv (fun N => sum_f_R0 (fun k => dot row (map (fun i => y i k) (seq a m)) * (/ INR (fact k) * t ^ k)) N)
    (dot row (map l (seq a m))).
Proof.
  intros y l t; induction row as [|c row IH]; intros a [|m] H; cbn [dot seq map];
    try (apply (same_limit (fun _ => 0)); [intro N; induction N as [|N E]; cbn [sum_f_R0]; [|rewrite <- E]; ring|];
         intros eps epos; exists O; intros k _; unfold R_dist; rewrite Rminus_0_r, Rabs_R0; exact epos).
  eapply same_limit; [intro N; symmetry; apply SP_sum|].
  apply (CV_plus (fun N => IZR c * sum_f_R0 (fun k => y a k * (/ INR (fact k) * t ^ k)) N)); [|apply IH, H].
  apply (CV_mult (fun _ => IZR c)); [|apply H].
  intros eps epos; exists O; intros k _; unfold R_dist; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; exact epos.
Qed.
Theorem sol_solves : forall n d dpos A s, length A = n -> length s = n -> solves n d A (sol d dpos A s).
Proof.
  intros n d dpos A s LA Ls i t I; eapply derivable_same; [reflexivity| |apply sol_derivative].
  apply (UL_sequence _ _ _ (sol_limit d dpos A (applied d A s) i t)); unfold Rdiv, SP.
  pose proof (dot_limit (fun j k => nth j (powers_of d A s k) 0) (fun j => sol d dpos A s j t) t (nth i A []) 0 n
    (fun j => sol_limit d dpos A s j t)) as H.
  fold (listed n (fun j => sol d dpos A s j t)) in H.
  apply (same_limit (fun N => sum_f_R0 (fun k => dot (nth i A []) (map (fun j => nth j (powers_of d A s k) 0) (seq 0 n))
    * (/ INR (fact k) * t ^ k)) N * / IZR d)).
  - intro N; rewrite Rmult_comm, scal_sum; apply sum_eq; intros k _; unfold part_of; rewrite <- powers_later; cbn [powers_of].
    unfold applied; rewrite <- (rows_by_place (IZR d) (powers_of d A s k) A), nth_listed by lia.
    pose proof (listed_again (powers_of d A s k)) as E; unfold listed in E; rewrite powers_length, LA in E by lia.
    rewrite E; unfold Rdiv; ring.
  - apply (CV_mult _ (fun _ => / IZR d)); [exact H|].
    intros eps epos; exists O; intros k _; unfold R_dist; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; exact epos.
Qed.

(* ---- One after the other: F j from the time [jump j] on, for a time tau j ---- *)

Section Joined.
Variables (tau : nat -> R) (least : R) (F : nat -> nat -> R -> R).
Hypotheses (pos : 0 < least) (long : forall j, least <= tau j) (meets : forall j k, F j k (tau j) = F (S j) k 0).

Fixpoint jump (j : nat) : R := match j with O => 0 | S i => jump i + tau i end.
Fixpoint place (N : nat) (t : R) : nat := match N with O => O | S i => if Rle_dec (jump (S i)) t then S i else place i t end.
Definition index (t : R) : nat := place (Z.to_nat (up (Rabs t / least))) t.
Definition joined (k : nat) (t : R) : R := F (index t) k (t - jump (index t)).

Lemma jump_later : forall i j, (i <= j)%nat -> jump i + INR (j - i) * least <= jump j.
Proof.
  intros i j L; replace j with (i + (j - i))%nat at 2 by lia; generalize (j - i)%nat; clear j L; intro k.
  induction k as [|k IH]; [rewrite Nat.add_0_r; cbn; lra|].
  rewrite S_INR, Nat.add_succ_r; cbn [jump]; pose proof (long (i + k)); lra.
Qed.
Lemma place_spec : forall N t, t < jump (S N) -> (place N t = O \/ jump (place N t) <= t) /\ t < jump (S (place N t)).
Proof.
  induction N as [|N IH]; intros t L; cbn [place]; [split; [now left|exact L]|].
  destruct (Rle_dec (jump (S N)) t) as [H|H]; [split; [now right|exact L]|apply IH; lra].
Qed.
Lemma index_spec : forall t, (index t = O \/ jump (index t) <= t) /\ t < jump (S (index t)).
Proof.
  intro t; apply place_spec; set (N := Z.to_nat (up (Rabs t / least))).
  pose proof (jump_later 0 (S N) ltac:(lia)) as L; rewrite Nat.sub_0_r, S_INR in L; cbn [jump] in L.
  destruct (archimed (Rabs t / least)) as [A _].
  assert (Q : 0 <= Rabs t / least) by (apply Rmult_le_pos; [apply Rabs_pos|left; now apply Rinv_0_lt_compat]).
  assert (E : Rabs t / least < INR N).
  { unfold N; rewrite INR_IZR_INZ, Z2Nat.id; [exact A|]; apply le_IZR; lra. }
  apply (Rmult_lt_compat_r least) in E; [|exact pos].
  replace (Rabs t / least * least) with (Rabs t) in E by (field; lra).
  cbn [jump] in *; pose proof (Rle_abs t); lra.
Qed.
Lemma index_in : forall j t, (j = O \/ jump j <= t) -> t < jump (S j) -> index t = j.
Proof.
  intros j t A B; destruct (index_spec t) as [C D]; set (i := index t) in *.
  destruct (Nat.lt_trichotomy i j) as [L|[L|L]]; [|exact L|]; exfalso.
  - pose proof (jump_later (S i) j L); assert (0 <= INR (j - S i) * least) by (apply Rmult_le_pos; [apply pos_INR|lra]).
    destruct A as [A|A]; [lia|lra].
  - pose proof (jump_later (S j) i L); assert (0 <= INR (i - S j) * least) by (apply Rmult_le_pos; [apply pos_INR|lra]).
    destruct C as [C|C]; [lia|lra].
Qed.
Lemma joined_at : forall j k, joined k (jump j) = F j k 0.
Proof.
  intros j k; unfold joined; pose proof (long j); rewrite (index_in j) by (try right; cbn [jump]; lra); f_equal; ring.
Qed.

(* Near a time that is no jump it is one of the functions. *)
Lemma joined_near : forall t, (forall j, t <> jump (S j)) -> exists e, 0 < e /\
  forall s, Rabs (s - t) < e -> index s = index t.
Proof.
  intros t N; destruct (index_spec t) as [A B]; set (j := index t) in *.
  exists (Rmin (jump (S j) - t) (match j with O => 1 | S _ => t - jump j end)); split.
  - apply Rmin_pos; [lra|]; destruct j as [|j]; [lra|]; destruct A as [A|A]; [discriminate|]; specialize (N j); lra.
  - intros s D; pose proof (Rmin_l (jump (S j) - t) (match j with O => 1 | S _ => t - jump j end)).
    pose proof (Rmin_r (jump (S j) - t) (match j with O => 1 | S _ => t - jump j end)); apply Rabs_def2 in D.
    apply index_in; [|lra]; destruct j as [|j]; [now left|right; lra].
Qed.
Lemma joined_derivable : forall k t l, (forall j, t <> jump (S j)) ->
  derivable_pt_lim (F (index t) k) (t - jump (index t)) l -> derivable_pt_lim (joined k) t l.
Proof.
  intros k t l N D eps epos; destruct (D eps epos) as [d H]; destruct (joined_near t N) as [e [e0 E]].
  assert (m0 : 0 < Rmin d e) by (apply Rmin_pos; [apply cond_pos|exact e0]).
  exists (mkposreal _ m0); cbn; intros h h0 L; pose proof (Rmin_l d e); pose proof (Rmin_r d e).
  unfold joined; rewrite (E (t + h)) by (replace (t + h - t) with h by ring; lra).
  replace (t + h - jump (index t)) with (t - jump (index t) + h) by ring; apply H; [exact h0|lra].
Qed.
Lemma joined_continuous : (forall j k t, continuity_pt (F j k) t) -> forall k t, continuity_pt (joined k) t.
Proof.
  intros Cont k t eps epos.
  assert (cases : (forall j, t <> jump (S j)) \/ exists j, t = jump (S j)).
  { destruct (index_spec t) as [A B]; destruct (Req_dec t (jump (index t))) as [E|E].
    - destruct (index t) as [|j] eqn:I; [left|right; now exists j].
      intros j E'; pose proof (jump_later 0 (S j) ltac:(lia)) as L; rewrite Nat.sub_0_r, S_INR in L.
      pose proof (pos_INR j); change (jump 0) with 0 in *; nra.
    - left; intros j E'; apply E; rewrite (index_in (S j) t); [exact E'|right; lra|].
      pose proof (long (S j)); cbn [jump] in *; lra. }
  destruct cases as [N|[j ->]].
  - destruct (Cont (index t) k (t - jump (index t)) eps epos) as [d [d0 H]]; destruct (joined_near t N) as [e [e0 E]].
    exists (Rmin d e); split; [now apply Rmin_pos|]; intros s [_ L]; cbn in *; unfold R_dist in *.
    pose proof (Rmin_l d e); pose proof (Rmin_r d e); unfold joined; rewrite (E s) by lra.
    destruct (Req_dec s t) as [->|ne]; [rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; lra|].
    apply H; split; [split; [exact I|lra]|].
    replace (s - jump (index t) - (t - jump (index t))) with (s - t) by ring; lra.
  - destruct (Cont j k (tau j) eps epos) as [d [d0 H]]; destruct (Cont (S j) k 0 eps epos) as [e [e0 E]].
    pose proof (long j) as L0; pose proof (long (S j)) as L1.
    exists (Rmin (Rmin d e) least); split; [repeat apply Rmin_pos; assumption|]; intros s [_ L]; cbn [dist R_met] in *.
    unfold R_dist in *; pose proof (Rmin_l (Rmin d e) least); pose proof (Rmin_r (Rmin d e) least).
    pose proof (Rmin_l d e); pose proof (Rmin_r d e); rewrite joined_at.
    assert (P : - least < s - jump (S j) < least) by (apply Rabs_def2 in L; lra).
    destruct (Rlt_le_dec s (jump (S j))) as [B|B]; unfold joined.
    + rewrite (index_in j) by (try right; cbn [jump] in *; lra); rewrite <- meets; apply H.
      cbn [jump] in *; split; [split; [exact I|lra]|]; cbn; unfold R_dist.
      replace (s - jump j - tau j) with (s - (jump j + tau j)) by ring; lra.
    + rewrite (index_in (S j)) by (try right; cbn [jump] in *; lra).
      destruct (Req_dec s (jump (S j))) as [->|ne].
      * replace (jump (S j) - jump (S j)) with 0 by ring; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; lra.
      * apply E; split; [split; [exact I|lra]|]; cbn [jump] in *; cbn; unfold R_dist; rewrite Rminus_0_r; lra.
Qed.
End Joined.

(* ---- Stays in turn: V falls around the period, and is negative at the start ---- *)

(* Of each stay d, the rows of d x', the step h = d p/q, and the forms at the beginning of each step. *)
Definition stay := (Z * (list (list Z) * ((Z * Z) * list triangle)))%type.
Definition stay_at (ss : list stay) (j : nat) : stay := nth (j mod length ss) ss (1%Z, ([], ((1%Z, 1%Z), []))).
Definition rows_of (s : stay) : list (list Z) := fst (snd s).
Definition first_of (s : stay) : triangle := hd [] (snd (snd (snd s))).
Definition lasts (s : stay) : R :=
  let '(d, (_, ((p, q), Qs))) := s in IZR (Z.of_nat (length Qs)) * (IZR d * IZR p / IZR q).
Fixpoint pieces_ok (n m : nat) (d D : Z) (A : list (list Z)) (p q : Z) (Qs : list triangle) (after : triangle) : bool :=
  match Qs with
  | [] => true
  | Q :: r => piece_ok n m d D A p q Q (hd after r) && pieces_ok n m d D A p q r after
  end.
Definition stay_ok (n m : nat) (D : Z) (s : stay) (after : triangle) : bool :=
  let '(d, (A, ((p, q), Qs))) := s in
  (0 <? d)%Z && (0 <? p)%Z && (0 <? q)%Z && (length A =? n)%nat && negb (length Qs =? 0)%nat &&
  pieces_ok n m d D A p q Qs after.
Definition stays_ok (n m : nat) (D : Z) (ss : list stay) : bool :=
  (0 <? D)%Z && forallb (fun j => stay_ok n m D (stay_at ss j) (first_of (stay_at ss (S j)))) (seq 0 (length ss)).

Lemma pieces_fall : forall n m d D A p q after f, (0 < d)%Z -> (0 < q)%Z -> (0 < p)%Z -> (0 < D)%Z -> length A = n ->
  solves n d A f -> forall Qs Q a, pieces_ok n m d D A p q (Q :: Qs) after = true ->
  let b := a + INR (length (Q :: Qs)) * (IZR d * IZR p / IZR q) in
  qf after (at_once n f b) + IZR D * norm2 (at_once n f b) <= qf Q (at_once n f a).
Proof.
  intros n m d D A p q after f dp qp pp Dp L S0; set (h := IZR d * IZR p / IZR q).
  induction Qs as [|Q' Qs IH]; intros Q a test; cbn [pieces_ok hd] in test; apply andb_true_iff in test as [one rest].
  - pose proof (piece_falls n m d D A p q Q after f a one dp qp pp L S0) as K; fold h in K.
    cbn [length INR]; rewrite Rmult_1_l; exact K.
  - pose proof (piece_falls n m d D A p q Q Q' f a one dp qp pp L S0) as K; fold h in K.
    specialize (IH Q' (a + h) rest); cbn zeta in IH |- *.
    replace (a + INR (length (Q :: Q' :: Qs)) * h) with (a + h + INR (length (Q' :: Qs)) * h)
      by (change (length (Q :: Q' :: Qs)) with (S (length (Q' :: Qs))); rewrite S_INR; ring).
    apply IZR_lt in Dp; pose proof (norm2_nonneg (at_once n f (a + h))); nra.
Qed.
Lemma falls_without_end : forall (v s : nat -> R) D K, 0 < D -> 0 < K ->
  (forall j, v (S j) + D * s (S j) <= v j) -> (forall j, 0 <= v j + K * s j) -> (forall j, 0 <= s j) -> v O < 0 ->
  forall B, exists j, B < s j.
Proof.
  intros v s D K Dp Kp falls low sp neg B; set (e := D * - v O / K).
  assert (epos : 0 < e) by (unfold e; apply Rdiv_lt_0_compat; nra).
  assert (down : forall j, v j <= v O - INR j * e).
  { induction j as [|j IH]; [cbn; lra|]; rewrite S_INR; pose proof (falls j); pose proof (low (S j)); pose proof (sp (S j)).
    pose proof (pos_INR j); assert (v (S j) <= v O) by nra.
    assert (e <= D * s (S j)); [|lra].
    apply (Rmult_le_reg_l K); [exact Kp|]; replace (K * e) with (D * - v O) by (unfold e; field; lra); nra. }
  destruct (archimed (K * Rabs B / e)) as [A _]; set (j := Z.to_nat (up (K * Rabs B / e))) in *.
  assert (Q : 0 <= K * Rabs B / e).
  { apply Rmult_le_pos; [pose proof (Rabs_pos B); nra|left; now apply Rinv_0_lt_compat]. }
  assert (T : K * Rabs B / e < INR j) by (unfold j; rewrite INR_IZR_INZ, Z2Nat.id; [exact A|apply le_IZR; lra]).
  apply (Rmult_lt_compat_r e) in T; [|exact epos].
  replace (K * Rabs B / e * e) with (K * Rabs B) in T by (field; lra).
  exists j; pose proof (down j); pose proof (low j); pose proof (Rle_abs B).
  apply (Rmult_lt_reg_l K); [exact Kp|]; assert (K * B <= K * Rabs B) by (apply Rmult_le_compat_l; lra); lra.
Qed.

Lemma in_turn_plain : forall n m D start ss, ss <> [] -> length start = n -> stays_ok n m D ss = true ->
  qf (first_of (stay_at ss 0)) start < 0 ->
  exists (x : nat -> R -> R) (jump : nat -> R) (index : R -> nat),
    jump O = 0 /\ (forall j, jump (S j) = jump j + lasts (stay_at ss j)) /\
    (forall j t, jump j <= t < jump (S j) -> index t = j) /\
    (forall k t, continuity_pt (x k) t) /\
    (forall k t, (k < n)%nat -> (forall j, t <> jump j) -> let s := stay_at ss (index t) in
      derivable_pt_lim (x k) t (dot (nth k (rows_of s) []) (at_once n x t) / IZR (fst s))) /\
    (forall B, exists t, 0 <= t /\ B < norm2 (at_once n x t)).
Proof.
  intros n m D start ss some Ls test neg; unfold stays_ok in test.
  rewrite andb_true_iff, Z.ltb_lt, forallb_forall in test; destruct test as [Dp test].
  assert (P : (0 < length ss)%nat) by (destruct ss; [contradiction|cbn; lia]).
  assert (ok : forall j, stay_ok n m D (stay_at ss j) (first_of (stay_at ss (S j))) = true).
  { intro j; pose proof (test (j mod length ss)%nat) as T; rewrite in_seq in T.
    pose proof (Nat.mod_upper_bound j (length ss) ltac:(lia)).
    specialize (T ltac:(lia)); unfold stay_at in *; rewrite Nat.mod_mod in T by lia.
    replace (S j mod length ss)%nat with (S (j mod length ss) mod length ss)%nat; [exact T|].
    change (S (j mod length ss)) with (1 + j mod length ss)%nat; rewrite Nat.add_mod_idemp_r by lia; reflexivity. }
  clear test.
  assert (dpos : forall j, (0 < fst (stay_at ss j))%Z).
  { intro j; specialize (ok j); destruct (stay_at ss j) as [d [A [[p q] Qs]]]; unfold stay_ok in ok.
    rewrite !andb_true_iff, !Z.ltb_lt in ok; cbn [fst]; tauto. }
  set (state := fix state (j : nat) : list R := match j with
    | O => start
    | S i => listed n (fun k => sol (fst (stay_at ss i)) (dpos i) (rows_of (stay_at ss i)) (state i) k (lasts (stay_at ss i)))
    end).
  set (F := fun j => sol (fst (stay_at ss j)) (dpos j) (rows_of (stay_at ss j)) (state j)).
  assert (Lst : forall j, length (state j) = n) by (intros [|j]; [exact Ls|apply listed_length]).
  assert (Lr : forall j, length (rows_of (stay_at ss j)) = n).
  { intro j; specialize (ok j); unfold rows_of; destruct (stay_at ss j) as [d [A [[p q] Qs]]]; unfold stay_ok in ok.
    rewrite !andb_true_iff, Nat.eqb_eq in ok; cbn [fst snd]; tauto. }
  assert (solve : forall j, solves n (fst (stay_at ss j)) (rows_of (stay_at ss j)) (F j)) by (intro j; now apply sol_solves).
  assert (begin : forall j, at_once n (F j) 0 = state j).
  { intro j; unfold at_once, listed, F; erewrite map_ext by (intro k; apply sol_start).
    rewrite <- (Lst j); apply listed_again. }
  assert (zero : forall j k t, (n <= k)%nat -> F j k t = 0).
  { intros j k t K; unfold F; apply (UL_sequence _ _ _ (sol_limit _ _ _ _ _ _)).
    assert (E : forall i, part_of (fst (stay_at ss j)) (rows_of (stay_at ss j)) (state j) k i t = 0).
    { intro i; unfold part_of; rewrite nth_overflow; [ring|].
      rewrite powers_length; rewrite Lr; [exact K|apply Lst]. }
    apply (same_limit (fun _ => 0)).
    - intro N; unfold SP; induction N as [|N IH]; cbn [sum_f_R0]; rewrite E; lra.
    - intros e e0; exists O; intros N _; unfold R_dist; rewrite Rminus_0_r, Rabs_R0; exact e0. }
  set (tau := fun j => lasts (stay_at ss j)).
  assert (meets : forall j k, F j k (tau j) = F (S j) k 0).
  { intros j k; destruct (Nat.lt_ge_cases k n) as [K|K]; [|now rewrite !zero].
    unfold F at 2; rewrite sol_start; cbn [state]; unfold listed; now rewrite nth_listed. }
  assert (least : exists e, 0 < e /\ forall j, e <= tau j).
  { assert (H : exists e, 0 < e /\ forall r, (r < length ss)%nat -> e <= tau r).
    { assert (tp : forall j, 0 < tau j).
      { intro j; specialize (ok j); unfold tau, lasts; destruct (stay_at ss j) as [d [A [[p q] Qs]]]; unfold stay_ok in ok.
        rewrite !andb_true_iff, !Z.ltb_lt, negb_true_iff, Nat.eqb_neq in ok; destruct ok as [[[[[d0 p0] q0] _] Q0] _].
        apply IZR_lt in d0, p0, q0; apply Rmult_lt_0_compat; [apply IZR_lt; lia|apply Rdiv_lt_0_compat; nra]. }
      generalize (length ss); induction n0 as [|N [e [e0 E]]]; [exists 1; split; [lra|intros; lia]|].
      exists (Rmin e (tau N)); split; [apply Rmin_pos; auto|]; intros r L.
      destruct (Nat.eq_dec r N) as [->|ne]; [apply Rmin_r|apply Rle_trans with e; [apply Rmin_l|apply E; lia]]. }
    destruct H as [e [e0 E]]; exists e; split; [exact e0|]; intro j.
    specialize (E (j mod length ss)%nat ltac:(apply Nat.mod_upper_bound; lia)); unfold tau, stay_at in *.
    rewrite Nat.mod_mod in E by lia; exact E. }
  destruct least as [e [e0 long]].
  assert (at_jump : forall j, at_once n (joined tau e F) (jump tau j) = state j).
  { intro j; rewrite <- begin; unfold at_once, listed; apply map_ext; intro k; now apply joined_at. }
  exists (joined tau e F), (jump tau), (index tau e).
  split; [reflexivity|split; [reflexivity|split; [|split; [|split]]]].
  - intros j t [A B]; apply index_in; auto.
  - intros k t; apply joined_continuous; auto; intros j i u.
    destruct (Nat.lt_ge_cases i n) as [K|K].
    + apply derivable_continuous_pt; eexists; apply solve; exact K.
    + intros ep E; exists 1; split; [lra|]; intros s _; cbn; rewrite !zero by exact K; unfold R_dist.
      rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; exact E.
  - intros k t K N s; apply joined_derivable; auto; unfold at_once, joined; apply solve; exact K.
  - intro B; set (v := fun j => qf (first_of (stay_at ss j)) (state j)); set (z := fun j => norm2 (state j)).
    assert (each : forall j, v (S j) + IZR D * z (S j) <= v j).
    { intro j; unfold v, z; pose proof (ok j) as T; unfold stay_ok in T; pose proof (solve j) as So; pose proof (Lr j) as L.
      rewrite <- (begin j); replace (state (S j)) with (at_once n (F j) (0 + tau j)) by (rewrite Rplus_0_l; reflexivity).
      set (after := first_of (stay_at ss (S j))) in *; clearbody after.
      unfold tau, first_of, rows_of, lasts in *; clear - So L T Dp; destruct (stay_at ss j) as [d [A [[p q] Qs]]].
      cbn [fst snd] in *; rewrite !andb_true_iff, !Z.ltb_lt, negb_true_iff, Nat.eqb_neq in T.
      destruct T as [[[[[d0 p0] q0] _] Q0] T].
      destruct Qs as [|Q Qs]; [cbn in Q0; lia|]; cbn [hd]; rewrite <- INR_IZR_INZ.
      now apply (pieces_fall n m d D A p q after (F j)). }
    assert (bounded : exists K, 0 < K /\ forall j, IZR (size_of (first_of (stay_at ss j))) <= K).
    { assert (H : exists K, 0 < K /\ forall r, (r < length ss)%nat -> IZR (size_of (first_of (stay_at ss r))) <= K).
      { generalize (length ss); induction n0 as [|N [K [K0 E]]]; [exists 1; split; [lra|intros; lia]|].
        exists (Rmax K (IZR (size_of (first_of (stay_at ss N))))); split; [apply Rlt_le_trans with K; [exact K0|apply Rmax_l]|].
        intros r L; destruct (Nat.eq_dec r N) as [->|ne]; [apply Rmax_r|apply Rle_trans with K; [apply E; lia|apply Rmax_l]]. }
      destruct H as [K [K0 E]]; exists K; split; [exact K0|]; intro j.
      specialize (E (j mod length ss)%nat ltac:(apply Nat.mod_upper_bound; lia)); unfold stay_at in *.
      rewrite Nat.mod_mod in E by lia; exact E. }
    destruct bounded as [K [K0 bound]].
    destruct (falls_without_end v z (IZR D) K (IZR_lt _ _ Dp) K0 each) with (B := B) as [j J].
    + intro j; unfold v, z; pose proof (size_bound (first_of (stay_at ss j)) (state j)) as S1.
      pose proof (Rle_abs (- qf (first_of (stay_at ss j)) (state j))) as S2; rewrite Rabs_Ropp in S2.
      pose proof (Rmult_le_compat_r _ _ _ (norm2_nonneg (state j)) (bound j)); lra.
    + intro j; apply norm2_nonneg.
    + exact neg.
    + exists (jump tau j); split; [|rewrite at_jump; exact J].
      pose proof (jump_later tau e long 0 j ltac:(lia)) as L; cbn [jump] in L.
      assert (0 <= INR (j - 0) * e) by (apply Rmult_le_pos; [apply pos_INR|lra]); lra.
Qed.

(* One stay for all times. *)
Lemma kept_plain : forall n m D s start, stays_ok n m D [s] = true -> length start = n -> qf (first_of s) start < 0 ->
  exists x : nat -> R -> R,
    (forall k t, (k < n)%nat ->
      derivable_pt_lim (x k) t (dot (nth k (rows_of s) []) (at_once n x t) / IZR (fst s))) /\
    (forall B, exists t, 0 <= t /\ B < norm2 (at_once n x t)).
Proof.
  intros n m D [d [A [[p q] Qs]]] start test L neg; unfold stays_ok in test.
  cbn [length seq forallb] in test; change (stay_at [(d, (A, ((p, q), Qs)))] 0) with (d, (A, ((p, q), Qs))) in test.
  change (stay_at [(d, (A, ((p, q), Qs)))] 1) with (d, (A, ((p, q), Qs))) in test.
  unfold stay_ok, first_of, rows_of in *; cbn [fst snd] in *; rewrite !andb_true_iff, !Z.ltb_lt, negb_true_iff, !Nat.eqb_neq, Nat.eqb_eq in test.
  destruct test as [Dp [[[[[[d0 p0] q0] LA] Q0] test] _]]; destruct Qs as [|Q Qs]; [cbn in Q0; lia|]; cbn [hd] in *.
  set (x := sol d d0 A start); assert (So : solves n d A x) by now apply sol_solves.
  exists x; split; [intros k t K; apply So, K|]; intro B.
  set (T := INR (length (Q :: Qs)) * (IZR d * IZR p / IZR q)); set (z := fun j => at_once n x (INR j * T)).
  pose proof (IZR_lt _ _ d0) as d1; pose proof (IZR_lt _ _ p0) as p1; pose proof (IZR_lt _ _ q0) as q1.
  assert (Tp : 0 <= T).
  { apply Rmult_le_pos; [apply pos_INR|left; apply Rdiv_lt_0_compat; [now apply Rmult_lt_0_compat|exact q1]]. }
  destruct (falls_without_end (fun j => qf Q (z j)) (fun j => norm2 (z j)) (IZR D) (1 + IZR (size_of Q))) with (B := B) as [j J].
  - now apply IZR_lt.
  - pose proof (size_nonneg Q); lra.
  - intro j; pose proof (pieces_fall n m d D A p q Q x d0 q0 p0 Dp LA So Qs Q (INR j * T) test) as K; cbn zeta in K.
    fold T in K; unfold z; rewrite S_INR; replace ((INR j + 1) * T) with (INR j * T + T) by ring; exact K.
  - intro j; pose proof (size_bound Q (z j)) as S1; pose proof (Rle_abs (- qf Q (z j))) as S2; rewrite Rabs_Ropp in S2.
    pose proof (norm2_nonneg (z j)); lra.
  - intro j; apply norm2_nonneg.
  - unfold z; cbn [INR]; rewrite Rmult_0_l; unfold at_once, listed, x; erewrite map_ext by (intro k; apply sol_start).
    rewrite <- L; fold (listed (length start) (fun k => nth k start 0)); rewrite listed_again; exact neg.
  - exists (INR j * T); split; [apply Rmult_le_pos; [apply pos_INR|exact Tp]|exact J].
Qed.

(* The same of A + e, e >= 0: e^(e t) times the solutions, which are not smaller. *)
Lemma dot_scaled : forall c r z, dot r (map (Rmult c) z) = c * dot r z.
Proof. intros c; induction r as [|a r IH]; intros [|y z]; cbn [dot map]; try ring; rewrite IH; ring. Qed.
Lemma at_once_scaled : forall n (x : nat -> R -> R) (c : R -> R) t,
  at_once n (fun k t => c t * x k t) t = map (Rmult (c t)) (at_once n x t).
Proof. intros; unfold at_once, listed; now rewrite map_map. Qed.
Lemma up_solution : forall e n r d (z : nat -> R -> R) k t, derivable_pt_lim (z k) t (dot r (at_once n z t) / d) ->
  derivable_pt_lim (fun t => exp (e * t) * z k t) t
    (dot r (at_once n (fun k t => exp (e * t) * z k t) t) / d + e * (exp (e * t) * z k t)).
Proof.
  intros e n r d z k t D; rewrite at_once_scaled, dot_scaled.
  apply (derivable_same (fun t => exp (e * t) * z k t) _ t
    (e * exp (e * t) * z k t + exp (e * t) * (dot r (at_once n z t) / d))); [reflexivity|unfold Rdiv; ring|].
  apply (derivable_pt_lim_mult (fun t => exp (e * t)) (z k)); [apply exp_flow|exact D].
Qed.
Lemma up_endless : forall e n (z : nat -> R -> R), 0 <= e -> (forall B, exists t, 0 <= t /\ B < norm2 (at_once n z t)) ->
  forall B, exists t, 0 <= t /\ B < norm2 (at_once n (fun k t => exp (e * t) * z k t) t).
Proof.
  intros e n z epos U B; destruct (U B) as [t [T H]]; exists t; split; [exact T|].
  rewrite at_once_scaled, norm2_scaled; apply Rlt_le_trans with (1 := H).
  assert (1 <= exp (e * t)).
  { rewrite <- exp_0; destruct (Req_dec (e * t) 0) as [->|N]; [lra|left; apply exp_increasing].
    assert (0 <= e * t) by now apply Rmult_le_pos. lra. }
  pose proof (norm2_nonneg (at_once n z t)).
  assert (1 * 1 <= exp (e * t) * exp (e * t)) by (apply Rmult_le_compat; lra).
  rewrite <- (Rmult_1_l (norm2 (at_once n z t))) at 1; apply Rmult_le_compat_r; lra.
Qed.
Theorem in_turn : forall e n m D start ss, 0 <= e -> ss <> [] -> length start = n -> stays_ok n m D ss = true ->
  qf (first_of (stay_at ss 0)) start < 0 ->
  exists (x : nat -> R -> R) (jump : nat -> R) (index : R -> nat),
    jump O = 0 /\ (forall j, jump (S j) = jump j + lasts (stay_at ss j)) /\
    (forall j t, jump j <= t < jump (S j) -> index t = j) /\
    (forall k t, continuity_pt (x k) t) /\
    (forall k t, (k < n)%nat -> (forall j, t <> jump j) -> let s := stay_at ss (index t) in
      derivable_pt_lim (x k) t (dot (nth k (rows_of s) []) (at_once n x t) / IZR (fst s) + e * x k t)) /\
    (forall B, exists t, 0 <= t /\ B < norm2 (at_once n x t)).
Proof.
  intros e n m D start ss epos some L test neg.
  destruct (in_turn_plain n m D start ss some L test neg) as [z [jump [index [J0 [J [I [C [F U]]]]]]]].
  exists (fun k t => exp (e * t) * z k t), jump, index.
  split; [exact J0|split; [exact J|split; [exact I|split; [|split]]]].
  - intros k t; apply (continuity_pt_mult (fun t => exp (e * t)) (z k)); [|apply C].
    apply derivable_continuous_pt; eexists; apply exp_flow.
  - intros k t K N s; apply up_solution, F; assumption.
  - now apply up_endless.
Qed.
Theorem kept : forall e n m D s start, 0 <= e -> stays_ok n m D [s] = true -> length start = n ->
  qf (first_of s) start < 0 -> exists x : nat -> R -> R,
    (forall k t, (k < n)%nat ->
      derivable_pt_lim (x k) t (dot (nth k (rows_of s) []) (at_once n x t) / IZR (fst s) + e * x k t)) /\
    (forall B, exists t, 0 <= t /\ B < norm2 (at_once n x t)).
Proof.
  intros e n m D s start epos test L neg; destruct (kept_plain n m D s start test L neg) as [z [F U]].
  exists (fun k t => exp (e * t) * z k t); split; [intros k t K; apply up_solution, F, K|now apply up_endless].
Qed.

(* Of one channel: the rows of a companion matrix but the last, e = p/q being subtracted. *)
Definition companions (n : nat) (p q : Z) (ss : list stay) : bool :=
  forallb (fun s => forallb (fun k => let c := nth k (nth k (rows_of s) []) 0%Z in
    same (nth k (rows_of s) []) (repeat 0%Z k ++ [c; fst s]) && (c * q =? - (p * fst s))%Z) (seq 0 (n - 1))) ss &&
  forallb (fun s => (0 <? fst s)%Z) ss && (0 <? q)%Z.
Lemma companion_row : forall n p q ss j k z, ss <> [] -> companions n p q ss = true -> (S k < n)%nat ->
  (S k < length z)%nat ->
  dot (nth k (rows_of (stay_at ss j)) []) z / IZR (fst (stay_at ss j)) + IZR p / IZR q * nth k z 0 = nth (S k) z 0.
Proof.
  intros n p q ss j k z some test K L; unfold companions in test; rewrite !andb_true_iff in test.
  destruct test as [[shape sign] qpos]; rewrite forallb_forall in shape, sign.
  assert (I : In (stay_at ss j) ss).
  { unfold stay_at; apply nth_In, Nat.mod_upper_bound; destruct ss; [contradiction|discriminate]. }
  specialize (shape _ I); specialize (sign _ I); rewrite forallb_forall in shape; apply Z.ltb_lt, IZR_lt in sign, qpos.
  specialize (shape k ltac:(apply in_seq; lia)); cbv zeta in shape; set (c := nth k (nth k _ []) 0%Z) in shape.
  apply andb_true_iff in shape as [E F]; rewrite (same_eq _ _ E), dot_pad; clearbody c; clear E.
  apply Z.eqb_eq, (f_equal IZR) in F; rewrite opp_IZR, !mult_IZR in F.
  assert (S0 : dot [c; fst (stay_at ss j)] (skipn k z) = IZR c * nth k z 0 + IZR (fst (stay_at ss j)) * nth (S k) z 0).
  { revert z L; clear; induction k as [|k IH]; intros [|x [|y z]] L; cbn [length] in L; try lia.
    - cbn [skipn dot nth]; ring.
    - change (skipn (S k) (x :: y :: z)) with (skipn k (y :: z)); rewrite IH by (cbn; lia); reflexivity. }
  rewrite S0; apply (Rmult_eq_reg_r (IZR q)); [|lra].
  replace (IZR c) with (- (IZR p * IZR (fst (stay_at ss j))) / IZR q) by (rewrite <- F; field; lra); field; lra.
Qed.
