(* ---- An orbit: stays of unknown durations, from where a form is 0 on, in a circle ---- *)

(* Of each stay d, the rows of d x', the step d p/q, how many steps, the start, the form that is 0 there, forms that stay >= 0. *)
Record leg := Leg { ld : Z; lA : list (list Z); lp : Z; lq : Z; lK : nat; lz : list Z; lent : list Z; lrows : list (list Z) }.
Definition node (A : list (list Z)) (p q : Z) (m K : nat) (v : list Z) (e : Z) : list Z :=
  match walk A p q m K v e with Some w => if fits m w (worst m K e) then w else [] | None => [] end.
Definition touches (g e : list Z) : bool := same g e || same g (scale (-1) e).
Lemma touches_0 : forall g e z, touches g e = true -> dot e z = 0 -> dot g z = 0.
Proof.
  intros g e z T E; apply orb_true_iff in T as [T|T]; apply same_eq in T; subst; [exact E|]; rewrite dot_scale, E; ring.
Qed.
Lemma node_walk : forall A p q m K v e, node A p q m K v e <> [] ->
  walk A p q m K v e = Some (node A p q m K v e) /\ walk A p q m (S K) v e <> None.
Proof.
  intros A p q m K v e H; unfold node in *; destruct (walk A p q m K v e) as [w|] eqn:E; [|contradiction].
  destruct (fits m w (worst m K e)) eqn:F; [|contradiction]; split; [reflexivity|]; clear H.
  revert v e E F; induction K as [|K IH]; intros v e E F; cbn [walk worst] in *.
  - injection E as ->; rewrite F; discriminate.
  - destruct (fits m v e) eqn:G; [|discriminate]; now apply IH.
Qed.

Lemma dot_app : forall r z r' z', length r = length z -> dot (r ++ r') (z ++ z') = dot r z + dot r' z'.
Proof. induction r as [|a r IH]; intros [|y z] r' z' L; try discriminate; cbn [app dot]; [ring|]; rewrite IH by (cbn in L; lia); ring. Qed.
Lemma nth_lcomb : forall a b u v i, length u = length v -> nth i (lcomb a b u v) 0 = a * nth i u 0 + b * nth i v 0.
Proof. intros a b; induction u as [|x u IH]; intros [|y v] [|i] L; try discriminate; cbn [lcomb nth]; try ring; apply IH; cbn in L; lia. Qed.
Lemma between_two : forall (g g' : R -> R), (forall c, derivable_pt_lim g c (g' c)) -> forall a b B, Rabs a <= B -> Rabs b <= B ->
  exists c, Rabs c <= B /\ g a - g b = (a - b) * g' c.
Proof.
  intros g g' H a b B Ba Bb; pose proof (abs_both _ _ Ba); pose proof (abs_both _ _ Bb).
  destruct (Rtotal_order a b) as [L|[->|L]].
  - destruct (MVT_cor2 g g' a b L (fun c _ => H c)) as [c [E C]]; exists c; split; [apply Rabs_le; lra|lra].
  - exists b; split; [exact Bb|ring].
  - destruct (MVT_cor2 g g' b a L (fun c _ => H c)) as [c [E C]]; exists c; split; [apply Rabs_le; lra|lra].
Qed.

Lemma joined_turns : forall tau least F, 0 < least -> (forall j, least <= tau j) -> (forall j k, F j k (tau j) = F (S j) k 0) ->
  forall j k l, derivable_pt_lim (F j k) (tau j) l -> derivable_pt_lim (F (S j) k) 0 l ->
  derivable_pt_lim (joined tau least F k) (jump tau (S j)) l.
Proof.
  intros tau least F pos long meets j k l D1 D2 eps epos; destruct (D1 eps epos) as [e1 H1]; destruct (D2 eps epos) as [e2 H2].
  assert (m0 : 0 < Rmin (Rmin e1 e2) least) by (repeat apply Rmin_pos; try apply cond_pos; exact pos).
  exists (mkposreal _ m0); intros h h0 L; cbn in L.
  pose proof (Rmin_l (Rmin e1 e2) least); pose proof (Rmin_r (Rmin e1 e2) least); pose proof (Rmin_l e1 e2); pose proof (Rmin_r e1 e2).
  rewrite joined_at by assumption; pose proof (long j) as L1; pose proof (long (S j)) as L2.
  pose proof (abs_both h _ (Rlt_le _ _ L)) as B; destruct (Rlt_le_dec h 0) as [N|P]; unfold joined.
  - rewrite (index_in tau least pos long j) by (try right; cbn [jump]; lra); rewrite <- meets; cbn [jump].
    replace (jump tau j + tau j + h - jump tau j) with (tau j + h) by ring; apply H1; [exact h0|lra].
  - assert (h < least) by (pose proof (Rle_abs h); lra).
    rewrite (index_in tau least pos long (S j)) by (try right; cbn [jump]; lra).
    replace (jump tau (S j) + h - jump tau (S j)) with (0 + h) by ring; apply H2; [exact h0|lra].
Qed.

Section Orbit.
Variables (n0 m : nat) (S : Z) (W : list Z) (Y : list (list Z)) (mus : list Z) (rho : Z) (legs : list leg).
Let N := Datatypes.S n0.
Let M := length legs.
Let D := (M * N)%nat.
Definition leg_at (i : nat) : leg := nth (i mod length legs) legs (Leg 0 [] 0 0 0 [] [] []).
Definition largest : Z := fold_right (fun r a => Z.max (row_size r) a) 0%Z Y.
Definition reach : Z := (largest * rho)%Z.
Definition y_at (i k : nat) : list Z := nth ((i mod length legs) * Datatypes.S n0 + k) Y [].
Definition mu_at (i k : nat) : Z := nth ((i mod length legs) * Datatypes.S n0 + k) mus 0%Z.
Definition error (K : nat) (e : Z) : Z := (worst m K e + divisor m * reach / S + 1)%Z.
Definition short (i k : nat) (jac : list Z) (rest : Z) : bool :=
  let mu := mu_at i k in
  (0 <? mu)%Z && (4 * row_size (add (repeat 0%Z ((i mod length legs) * Datatypes.S n0 + k) ++ [S * mu]%Z) (scale (-1) jac)) <=? S * mu)%Z &&
  (4 * rest <=? S * mu)%Z.
Definition state_ok (i k : nat) (w : list Z) (cols : list (list Z)) : bool :=
  let L := leg_at i in
  let V := (lp L * zdot (nth k (lA L) []) w / lq L)%Z in
  short i k (add (combine_forms (map (fun c => nth k c 0%Z) cols ++ [V]) (map (y_at i) (seq 0 (Datatypes.S n0))))
      (scale (- S) (y_at (Datatypes.S i) k)))
    (largest * (Z.of_nat n0 * nth k W 0 * error (lK L) 0 + nth k W 0 * error (lK L) reach + 1))%Z &&
  (2 * (Z.abs (nth k w 0%Z - nth k (lz (leg_at (Datatypes.S i))) 0) + nth k W 0 * worst m (lK L) 0) <=? mu_at i k * rho)%Z.
Definition leg_ok (i : nat) : bool :=
  let L := leg_at i in let N := Datatypes.S n0 in
  (0 <? ld L)%Z && (0 <? lp L)%Z && (0 <? lq L)%Z && (1 <=? lK L)%nat && (length (lA L) =? N)%nat &&
  step_small (lA L) W (lp L) (lq L) && zero (nth n0 (lA L) []) && (length (lz L) =? N)%nat && (nth n0 (lz L) 0 =? S)%Z &&
  (let w := node (lA L) (lp L) (lq L) m (lK L) (lz L) reach in
   let cols := map (fun j => node (lA L) (lp L) (lq L) m (lK L) (spot N j S) 0) (seq 0 n0) in
   (length w =? N)%nat && forallb (fun c => length c =? N)%nat cols && forallb (fun k => state_ok i k w cols) (seq 0 n0)) &&
  (short i n0 (combine_forms (scale S (firstn n0 (lent L))) (map (y_at i) (seq 0 n0))) 0 &&
   (2 * Z.abs (zdot (lent L) (lz L)) <=? mu_at i n0 * rho)%Z && (length (lent L) =? N)%nat) &&
  (let tr := trace (lA L) (lp L) (lq L) m (Datatypes.S (lK L)) (lz L) in
   forallb (fun g => let up := combine_forms g (lA L) in
     keeps (lA L) W m g up (scale (-1) up) (touches g (lent L)) (touches g (lent (leg_at (Datatypes.S i)))) reach tr) (lrows L)).
Definition orbit_ok : bool :=
  (0 <? S)%Z && (0 <=? rho)%Z && (2 * reach <=? S)%Z && (0 <? length legs)%nat && (length W =? Datatypes.S n0)%nat &&
  forallb (fun w => 1 <=? w)%Z W && forallb leg_ok (seq 0 (length legs)).

Hypothesis ok : orbit_ok = true.
Lemma basics : (0 < S)%Z /\ (0 <= rho)%Z /\ (2 * reach <= S)%Z /\ (0 < M)%nat /\ length W = N /\ Forall (fun w => 1 <= w)%Z W /\
  forall i, leg_ok i = true.
Proof.
  unfold orbit_ok in ok; rewrite !andb_true_iff, !Z.ltb_lt, !Z.leb_le, Nat.ltb_lt, Nat.eqb_eq, !forallb_forall in ok.
  destruct ok as [[[[[[A B] C] E] F] G] H]; repeat split; auto.
  - rewrite Forall_forall; intros w I; specialize (G w I); now apply Z.leb_le.
  - intro i; assert (X : forall j, leg_ok j = leg_ok (j mod length legs)).
    { intro j; unfold leg_ok, state_ok, short, mu_at, y_at, leg_at; rewrite Nat.mod_mod by lia.
      change (Datatypes.S (j mod length legs)) with (1 + j mod length legs)%nat; rewrite Nat.add_mod_idemp_r by lia; reflexivity. }
    rewrite X; apply H, in_seq; split; [lia|]; apply Nat.mod_upper_bound; lia.
Qed.
Let sp : (0 < S)%Z := proj1 basics.
Let r0 : (0 <= rho)%Z := proj1 (proj2 basics).
Let rS : (2 * reach <= S)%Z := proj1 (proj2 (proj2 basics)).
Let M0 : (0 < M)%nat := proj1 (proj2 (proj2 (proj2 basics))).
Let LW : length W = N := proj1 (proj2 (proj2 (proj2 (proj2 basics)))).
Let w1 : Forall (fun w => 1 <= w)%Z W := proj1 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))).

(* What is known of a stay. *)
Lemma leg_facts : forall i, let L := leg_at i in
  (0 < ld L)%Z /\ (0 < lp L)%Z /\ (0 < lq L)%Z /\ (1 <= lK L)%nat /\ length (lA L) = N /\
  step_small (lA L) W (lp L) (lq L) = true /\ zero (nth n0 (lA L) []) = true /\ length (lz L) = N /\ nth n0 (lz L) 0%Z = S.
Proof.
  intro i; pose proof (proj2 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))) i) as H; cbv zeta; unfold leg_ok in H; cbv zeta in H.
  rewrite !andb_true_iff, !Z.ltb_lt, !Nat.eqb_eq, Nat.leb_le, Z.eqb_eq in H; unfold N; tauto.
Qed.
Let dpos i := proj1 (leg_facts i).

Definition Phi (i j : nat) : nat -> R -> R := sol (ld (leg_at i)) (dpos i) (lA (leg_at i)) (map IZR (spot N j S)).
Definition moved (y : nat -> R) (i k : nat) : R := dot (y_at i k) (listed D y).
Definition zed (y : nat -> R) (i k : nat) : R := IZR (nth k (lz (leg_at i)) 0%Z) + moved y i k.
Definition start (y : nat -> R) (i : nat) : list R := listed n0 (zed y i) ++ [IZR S].
Definition th (y : nat -> R) (i : nat) : R := moved y i n0 / IZR S.
Definition hh (i : nat) : R := IZR (ld (leg_at i)) * IZR (lp (leg_at i)) / IZR (lq (leg_at i)).
Definition tm (y : nat -> R) (i : nat) : R := (INR (lK (leg_at i)) + th y i) * hh i.
Definition fl (y : nat -> R) (i : nat) : nat -> R -> R := blend (IZR S) (Phi i) 0 (start y i).
Definition small_box (y : nat -> R) : Prop := forall l, (l < D)%nat -> Rabs (y l) <= IZR rho.

Lemma Phi_solves : forall i j, solves N (ld (leg_at i)) (lA (leg_at i)) (Phi i j).
Proof. intros i j; apply sol_solves; [apply leg_facts|unfold spot; now rewrite !map_length, seq_length]. Qed.
Lemma Phi_start : forall i j k, (k < N)%nat -> Phi i j k 0 = if (k =? j)%nat then IZR S else 0.
Proof.
  intros i j k K; unfold Phi, spot; rewrite sol_start, map_map, nth_listed by exact K; now destruct (k =? j)%nat.
Qed.
Lemma fl_solves : forall y i, solves N (ld (leg_at i)) (lA (leg_at i)) (fl y i).
Proof. intros y i; apply blend_solves; [apply Rgt_not_eq, IZR_lt, dpos|intro; apply Phi_solves]. Qed.
Lemma start_length : forall y i, length (start y i) = N.
Proof. intros; unfold start; rewrite app_length, listed_length; cbn [length]; unfold N; lia. Qed.
Lemma fl_start : forall y i k, (k < N)%nat -> fl y i k 0 = nth k (start y i) 0.
Proof.
  intros y i k K; assert (S0 : IZR S <> 0) by (apply Rgt_not_eq, IZR_lt, sp); unfold fl.
  transitivity (if (0 <=? k)%nat then nth (k - 0) (start y i) 0 else 0); [|rewrite Nat.sub_0_r; reflexivity].
  apply (blend_start (IZR S) (Phi i) k S0); intro j; now apply Phi_start.
Qed.
Lemma start_nth : forall y i k, nth k (start y i) 0 = if (k <? n0)%nat then zed y i k else if (k =? n0)%nat then IZR S else 0.
Proof.
  intros y i k; unfold start; destruct (Nat.ltb_spec k n0) as [L|L].
  - rewrite app_nth1 by (now rewrite listed_length); unfold listed; now rewrite nth_listed.
  - rewrite app_nth2 by (now rewrite listed_length); rewrite listed_length; destruct (Nat.eqb_spec k n0) as [->|ne].
    + rewrite Nat.sub_diag; reflexivity.
    + rewrite nth_overflow by (cbn [length]; lia); reflexivity.
Qed.
Lemma largest_nonneg : (0 <= largest)%Z.
Proof. unfold largest; induction Y as [|r Y' IH]; cbn [fold_right]; lia. Qed.
Lemma reach_nonneg : (0 <= reach)%Z.
Proof. unfold reach; pose proof largest_nonneg; nia. Qed.
Lemma moved_bound : forall (y : nat -> R) c, 0 <= c -> (forall l, (l < D)%nat -> Rabs (y l) <= c) -> forall i k,
  Rabs (moved y i k) <= IZR largest * c.
Proof.
  intros y c c0 H i k; unfold moved, y_at; set (l := (_ + k)%nat).
  apply Rle_trans with (IZR (row_size (nth l Y [])) * c).
  - apply dot_size; [exact c0|]; intro j; destruct (Nat.lt_ge_cases j D) as [L|L].
    + unfold listed; rewrite nth_listed by exact L; now apply H.
    + rewrite nth_overflow by (now rewrite listed_length); rewrite Rabs_R0; exact c0.
  - apply Rmult_le_compat_r; [exact c0|]; apply IZR_le; unfold largest; generalize l; clear.
    induction Y as [|r Y' IH]; intros [|l]; cbn [nth fold_right row_size]; try lia; specialize (IH l); lia.
Qed.
Lemma moved_box : forall y, small_box y -> forall i k, Rabs (moved y i k) <= IZR reach.
Proof. intros y H i k; unfold reach; rewrite mult_IZR; apply moved_bound; [now apply IZR_le|exact H]. Qed.
Lemma moved_less : forall y y' i k, moved y i k - moved y' i k = moved (fun l => y l - y' l) i k.
Proof.
  intros; unfold moved; pose proof (dot_listed (y_at i k) (-1) y' y D) as E.
  replace (listed D (fun l => y l - y' l)) with (listed D (fun k => -1 * y' k + y k)); [rewrite E; ring|].
  unfold listed; apply map_ext; intro; ring.
Qed.
Lemma moved_0 : forall i k, moved (fun _ => 0) i k = 0.
Proof. intros; apply dot_zeros. Qed.
Lemma th_box : forall y, small_box y -> forall i, Rabs (th y i) <= IZR reach / IZR S /\ IZR reach / IZR S <= 1 / 2.
Proof.
  intros y H i; assert (s : 0 < IZR S) by (apply IZR_lt, sp); unfold th, Rdiv; split.
  - rewrite Rabs_mult, (Rabs_right (/ IZR S)) by (apply Rle_ge; left; now apply Rinv_0_lt_compat).
    apply Rmult_le_compat_r; [left; now apply Rinv_0_lt_compat|now apply moved_box].
  - apply (Rmult_le_reg_r (IZR S)); [exact s|]; rewrite Rmult_assoc, Rinv_l by lra; pose proof (IZR_le _ _ rS) as Q; rewrite mult_IZR in Q; lra.
Qed.
Lemma near_start : forall y i e, (0 <= e)%Z -> (forall k, (k < n0)%nat -> Rabs (moved y i k) <= IZR e) ->
  near N W (fl y i) 0 (lz (leg_at i)) e.
Proof.
  intros y i e e0 H; destruct (leg_facts i) as [_ [_ [_ [_ [_ [_ [_ [Lz Zn]]]]]]]].
  split; [exact Lz|split; [exact e0|]]; intro k; rewrite nth_less by (unfold at_once; now rewrite listed_length).
  destruct (Nat.lt_ge_cases k N) as [K|K].
  2: { rewrite !nth_overflow by (unfold at_once; rewrite ?listed_length; lia); rewrite Rminus_0_r, Rabs_R0; lra. }
  assert (w0 : 1 <= IZR (nth k W 0%Z)) by (apply IZR_le; rewrite Forall_forall in w1; apply w1, nth_In; lia).
  apply IZR_le in e0; unfold at_once, listed; rewrite nth_listed, fl_start, start_nth by exact K.
  destruct (Nat.ltb_spec k n0) as [L|L].
  - unfold zed; rewrite Rplus_comm; unfold Rminus; rewrite Rplus_assoc, Rplus_opp_r, Rplus_0_r; specialize (H k L); nra.
  - assert (k = n0) as -> by (unfold N in K; lia); rewrite Nat.eqb_refl, Zn, Rminus_diag_eq, Rabs_R0 by reflexivity; nra.
Qed.
Lemma leg_about : forall y i e, (0 <= e <= reach)%Z -> small_box y -> (forall k, (k < n0)%nat -> Rabs (moved y i k) <= IZR e) ->
  let L := leg_at i in let w := node (lA L) (lp L) (lq L) m (lK L) (lz L) reach in length w = N ->
  forall k t, (k < N)%nat -> Rabs t <= 1 ->
  Rabs (fl y i k ((INR (lK L) + t) * hh i) - IZR (nth k w 0%Z)) <= IZR (nth k W 0%Z) * (IZR (worst m (lK L) e) + IZR (divisor m) * Rabs t).
Proof.
  intros y i e [e0 eR] B H L w Lw k t K T; pose proof (leg_facts i) as F0; cbv zeta in F0; fold L in F0; destruct F0 as [d0 [p0 [q0 [K1 [LA [sm _]]]]]].
  assert (w <> []) by (intro E; rewrite E in Lw; discriminate).
  destruct (node_walk _ _ _ _ _ _ _ H0) as [W1 W2]; fold w in W1; unfold hh; fold L; destruct (lK L) as [|K']; [lia|].
  apply (about_node N (ld L) (lA L) W (lp L) (lq L) d0 p0 q0 LA LW w1 sm (fl y i) m (fl_solves y i) K' (lz L) e reach w);
    auto; now apply near_start.
Qed.
Lemma column_about : forall i j, let L := leg_at i in let w := node (lA L) (lp L) (lq L) m (lK L) (spot N j S) 0 in length w = N ->
  forall k t, (k < N)%nat -> Rabs t <= 1 ->
  Rabs (Phi i j k ((INR (lK L) + t) * hh i) - IZR (nth k w 0%Z)) <= IZR (nth k W 0%Z) * (IZR (worst m (lK L) 0) + IZR (divisor m) * Rabs t).
Proof.
  intros i j L w Lw k t K T; pose proof (leg_facts i) as F0; cbv zeta in F0; fold L in F0; destruct F0 as [d0 [p0 [q0 [K1 [LA [sm _]]]]]].
  assert (w <> []) by (intro E; rewrite E in Lw; discriminate).
  destruct (node_walk _ _ _ _ _ _ _ H) as [W1 W2]; fold w in W1; unfold hh; fold L; destruct (lK L) as [|K']; [lia|].
  apply (about_node N (ld L) (lA L) W (lp L) (lq L) d0 p0 q0 LA LW w1 sm (Phi i j) m (Phi_solves i j) K' (spot N j S) 0 0 w); auto; try lia.
  assert (Ls : length (spot N j S) = N) by (unfold spot; now rewrite map_length, seq_length).
  split; [exact Ls|split; [lia|]]; intro l; rewrite nth_less by (unfold at_once; rewrite listed_length; congruence).
  destruct (Nat.lt_ge_cases l N) as [I|I].
  - unfold at_once, listed; rewrite nth_listed, Phi_start by exact I; unfold spot.
    rewrite (nth_mapped _ _ _ (seq 0 N) l O), seq_nth by (rewrite ?seq_length; exact I); cbn [Nat.add].
    rewrite Rmult_0_r; destruct (l =? j)%nat; rewrite Rminus_diag_eq, Rabs_R0 by reflexivity; lra.
  - rewrite !nth_overflow by (unfold at_once; rewrite ?listed_length; lia); rewrite Rminus_0_r, Rabs_R0; lra.
Qed.

(* What a zero of F is, and that y - F/mu contracts. *)
Definition gap (y : nat -> R) (i k : nat) : R :=
  if (k <? n0)%nat then fl y i k (tm y i) - zed y (Datatypes.S i) k else dot (lent (leg_at i)) (start y i).
Lemma short_sound : forall i k jac rest, short i k jac rest = true -> (i < M)%nat -> (k < N)%nat ->
  forall (de : nat -> R) c FF rr, 0 <= c -> (forall l, (l < D)%nat -> Rabs (de l) <= c) ->
  IZR S * FF = dot jac (listed D de) + rr -> Rabs rr <= IZR rest * c -> Rabs (de (i * N + k)%nat - FF / IZR (mu_at i k)) <= c / 2.
Proof.
  intros i k jac rest H I K de c FF rr c0 B E R1; unfold short in H; rewrite !andb_true_iff, Z.ltb_lt, !Z.leb_le in H.
  rewrite Nat.mod_small in H by exact I; fold N in H; destruct H as [[mu0 H1] H2]; set (mu := mu_at i k) in *; set (l := (i * N + k)%nat) in *.
  apply IZR_lt in mu0; apply IZR_le in H1, H2; rewrite !mult_IZR in H1, H2; assert (s : 0 < IZR S) by (apply IZR_lt, sp).
  assert (lD : (l < D)%nat) by (unfold l, D, M in *; nia).
  set (r := add _ _) in H1; pose proof (dot_size r (listed D de) c c0) as Q.
  assert (Hd : dot r (listed D de) = IZR S * IZR mu * de l - dot jac (listed D de)).
  { unfold r; rewrite dot_add, dot_scale, dot_place, mult_IZR; unfold listed at 1; rewrite nth_listed by exact lD; ring. }
  specialize (Q ltac:(intro j; destruct (Nat.lt_ge_cases j D) as [L|L];
    [unfold listed; rewrite nth_listed by exact L; now apply B|rewrite nth_overflow by (now rewrite listed_length); rewrite Rabs_R0; exact c0])).
  rewrite Hd in Q; assert (P : 0 < IZR S * IZR mu) by now apply Rmult_lt_0_compat.
  replace (de l - FF / IZR mu) with ((IZR S * IZR mu * de l - dot jac (listed D de) - rr) / (IZR S * IZR mu))
    by (replace (dot jac (listed D de)) with (IZR S * FF - rr) by lra; field; lra).
  unfold Rdiv; rewrite Rabs_mult, (Rabs_right (/ _)) by (apply Rle_ge; left; now apply Rinv_0_lt_compat).
  apply (Rmult_le_reg_r (IZR S * IZR mu)); [exact P|]; rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra.
  unfold Rminus at 1; apply Rle_trans with (1 := Rabs_triang _ _); rewrite Rabs_Ropp.
  pose proof (Rmult_le_compat_r c _ _ c0 H1); pose proof (Rmult_le_compat_r c _ _ c0 H2); lra.
Qed.
Lemma error_enough : forall K e, (0 <= e)%Z -> forall t, Rabs t <= IZR reach / IZR S ->
  IZR (worst m K e) + IZR (divisor m) * Rabs t <= IZR (error K e).
Proof.
  intros K e e0 t T; unfold error; rewrite !plus_IZR; pose proof (rounded_down (divisor m * reach) S sp) as Q.
  rewrite mult_IZR in Q; pose proof (divisor_pos m) as Dp.
  assert (IZR (divisor m) * Rabs t <= IZR (divisor m) * (IZR reach / IZR S)) by (apply Rmult_le_compat_l; lra).
  unfold Rdiv in *; lra.
Qed.
Lemma start_less : forall y y' i k, nth k (lcomb 1 (-1) (start y i) (start y' i)) 0 = if (k <? n0)%nat then moved (fun l => y l - y' l) i k else 0.
Proof.
  intros; rewrite nth_lcomb, !start_nth by (now rewrite !start_length); destruct (k <? n0)%nat; [rewrite <- moved_less; unfold zed; ring|].
  destruct (k =? n0)%nat; ring.
Qed.
Lemma dot_start_less : forall r y y' i, length r = n0 ->
  dot r (lcomb 1 (-1) (start y i) (start y' i)) = dot r (listed n0 (moved (fun l => y l - y' l) i)).
Proof.
  intros r y y' i L; rewrite dot_lcomb by (now rewrite !start_length); unfold start.
  rewrite <- (app_nil_r r), !dot_app, app_nil_r by (now rewrite listed_length); cbn [dot].
  replace (listed n0 (moved (fun l => y l - y' l) i)) with (listed n0 (fun k => -1 * zed y' i k + zed y i k)); [rewrite dot_listed; ring|].
  unfold listed; apply map_ext; intro k; rewrite <- moved_less; unfold zed; ring.
Qed.
Lemma state_short : forall i k, (i < M)%nat -> (k < n0)%nat -> forall y y' c, 0 <= c -> small_box y -> small_box y' ->
  (forall l, (l < D)%nat -> Rabs (y l - y' l) <= c) ->
  Rabs ((y (i * N + k)%nat - y' (i * N + k)%nat) - (gap y i k - gap y' i k) / IZR (mu_at i k)) <= c / 2.
Proof.
  intros i k I K y y' c c0 By By' B; pose proof (proj2 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))) i) as H.
  unfold leg_ok in H; cbv zeta in H; rewrite !andb_true_iff in H; destruct H as [[[_ [[Hw Hc] Hs]] _] _].
  apply Nat.eqb_eq in Hw; rewrite forallb_forall in Hc, Hs; specialize (Hs k ltac:(apply in_seq; lia)).
  destruct (leg_facts i) as [d0 [p0 [q0 [K1 [LA [sm [_ [Lz _]]]]]]]].
  set (L := leg_at i) in *; set (w := node (lA L) (lp L) (lq L) m (lK L) (lz L) reach) in *.
  set (cols := map (fun j => node (lA L) (lp L) (lq L) m (lK L) (spot (Datatypes.S n0) j S) 0) (seq 0 n0)) in *.
  unfold state_ok in Hs; cbv zeta in Hs; fold L in Hs; apply andb_true_iff in Hs as [Hs _].
  set (V := (lp L * zdot (nth k (lA L) []) w / lq L)%Z) in *; set (rowE := map (fun c => nth k c 0%Z) cols) in *.
  set (de := fun l => y l - y' l); assert (s : 0 < IZR S) by (apply IZR_lt, sp).
  assert (KN : (k < N)%nat) by (unfold N; lia).
  assert (w0 : 1 <= IZR (nth k W 0%Z)) by (apply IZR_le; rewrite Forall_forall in w1; apply w1, nth_In; lia).
  pose proof (moved_bound de c c0 B) as Mv; pose proof (IZR_le _ _ largest_nonneg) as Y0.
  assert (LE : length rowE = n0) by (unfold rowE, cols; now rewrite !map_length, seq_length).
  pose proof (error_enough (lK L) 0 ltac:(lia)) as E1; pose proof (error_enough (lK L) reach reach_nonneg) as E2.
  destruct (th_box y By i) as [T1 T2]; destruct (th_box y' By' i) as [T1' _].
  set (X := IZR (nth k W 0%Z)) in *; set (e1 := IZR (error (lK L) 0)) in *; set (e2 := IZR (error (lK L) reach)) in *.
  assert (p1 : 0 <= e1) by (specialize (E1 0 ltac:(rewrite Rabs_R0; apply Rle_trans with (2 := T1); apply Rabs_pos)); pose proof (IZR_le _ _ (proj1 (worst_more m (lK L) 0 0 ltac:(lia) ltac:(lia)))); rewrite Rabs_R0 in E1; lra).
  assert (p2 : 0 <= e2) by (specialize (E2 0 ltac:(rewrite Rabs_R0; apply Rle_trans with (2 := T1); apply Rabs_pos)); pose proof (IZR_le _ _ (proj1 (worst_more m (lK L) reach reach ltac:(lia) reach_nonneg))); rewrite Rabs_R0 in E2; lra).
  (* the start *)
  assert (first : Rabs (IZR S * (fl y i k (tm y i) - fl y' i k (tm y i)) - dot rowE (listed n0 (moved de i))) <= INR n0 * (IZR largest * c * (X * e1))).
  { unfold fl; rewrite blend_less by (now rewrite !start_length); unfold de; rewrite <- (dot_start_less rowE y y' i LE); unfold rowE.
    replace (INR n0) with (INR (length cols)) by (unfold cols; now rewrite map_length, seq_length).
    apply blend_near; [exact s|nra|now apply Rmult_le_pos| | |].
    - intros j J; unfold cols in J; rewrite map_length, seq_length in J; rewrite Nat.add_0_l.
      assert (Ej : nth j cols [] = node (lA L) (lp L) (lq L) m (lK L) (spot N j S) 0).
      { unfold cols; rewrite (nth_mapped _ _ _ (seq 0 n0) j O) by (now rewrite seq_length); rewrite seq_nth by exact J; reflexivity. }
      rewrite Ej; apply Rle_trans with (X * (IZR (worst m (lK L) 0) + IZR (divisor m) * Rabs (th y i))).
      + apply column_about; [|exact KN|lra]; fold L; rewrite <- Ej; apply Nat.eqb_eq, Hc, nth_In; unfold cols; now rewrite map_length, seq_length.
      + apply Rmult_le_compat_l; [lra|now apply E1].
    - intro j; rewrite start_less; destruct (j <? n0)%nat; [apply Mv|rewrite Rabs_R0; now apply Rmult_le_pos].
    - intros j J; unfold cols in J; rewrite map_length, seq_length in J; rewrite start_less, (proj2 (Nat.ltb_ge j n0)) by exact J; reflexivity. }
  (* the duration *)
  destruct (between_two (fun t => fl y' i k (INR (lK L) * hh i + t * hh i))
    (fun t => IZR (lp L) / IZR (lq L) * dot (nth k (lA L) []) (at_once N (fl y' i) (INR (lK L) * hh i + t * hh i)))
    ltac:(intro t; exact (in_step N (ld L) (lA L) (lp L) (lq L) d0 q0 (fl y' i) (fl_solves y' i) k (INR (lK L) * hh i) t KN))
    (th y i) (th y' i) _ T1 T1') as [z [Z1 Z2]].
  set (G := IZR (lp L) / IZR (lq L) * dot (nth k (lA L) []) (at_once N (fl y' i) (INR (lK L) * hh i + z * hh i))) in *.
  assert (second : Rabs (G - IZR V) <= X * e2 + 1).
  { set (at_ := at_once N (fl y' i) (INR (lK L) * hh i + z * hh i)) in *.
    assert (La : length at_ = N) by apply listed_length.
    pose proof (rounded_down (lp L * zdot (nth k (lA L) []) w) (lq L) q0) as Rd; fold V in Rd; rewrite mult_IZR in Rd.
    assert (Q0 : 0 < IZR (lq L)) by now apply IZR_lt.
    replace (G - IZR V) with (IZR (lp L) / IZR (lq L) * (dot (nth k (lA L) []) at_ - IZR (zdot (nth k (lA L) []) w)) +
      (IZR (lp L) * IZR (zdot (nth k (lA L) []) w) / IZR (lq L) - IZR V)) by (unfold G; field; lra).
    rewrite dot_less by (rewrite La, Hw; reflexivity).
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite (Rabs_right (_ - IZR V)) by lra.
    assert (Rabs (IZR (lp L) / IZR (lq L) * dot (nth k (lA L) []) (less at_ w)) <= X * (e2 / 2)); [|nra].
    apply (moved_within N (lA L) W (lp L) (lq L) p0 q0 LA LW w1 sm); [unfold less; now rewrite listed_length| |exact p2|exact KN].
    intro j; rewrite nth_less by (rewrite La, Hw; reflexivity); destruct (Nat.lt_ge_cases j N) as [J|J].
    - unfold at_, at_once, listed; rewrite nth_listed by exact J.
      replace (INR (lK L) * hh i + z * hh i) with ((INR (lK L) + z) * hh i) by ring.
      assert (0 <= IZR (nth j W 0%Z)) by (apply Rle_trans with 1; [lra|]; apply IZR_le; rewrite Forall_forall in w1; apply w1, nth_In; lia).
      apply Rle_trans with (IZR (nth j W 0%Z) * (IZR (worst m (lK L) reach) + IZR (divisor m) * Rabs z)).
      + apply leg_about; [split; [apply reach_nonneg|lia]|exact By'|intros; now apply moved_box|exact Hw|exact J|lra].
      + apply Rmult_le_compat_l; [assumption|now apply E2].
    - rewrite !nth_overflow; rewrite ?La, ?Hw, ?LW; try exact J; rewrite Rminus_0_r, Rabs_R0; lra. }
  set (Sth := moved de i n0).
  assert (sth : IZR S * (th y i - th y' i) = Sth) by (unfold Sth, de; rewrite <- moved_less; unfold th; field; lra).
  refine (short_sound i k _ _ Hs I KN de c (gap y i k - gap y' i k)
    ((IZR S * (fl y i k (tm y i) - fl y' i k (tm y i)) - dot rowE (listed n0 (moved de i))) + Sth * (G - IZR V)) c0 B _ _).
  - rewrite dot_add, dot_scale, opp_IZR, dot_combine.
    replace (at_ (map (y_at i) (seq 0 (Datatypes.S n0))) (listed D de)) with (listed n0 (moved de i) ++ [moved de i n0])
      by (rewrite <- listed_S; unfold at_; rewrite map_map; reflexivity).
    rewrite dot_snoc by (rewrite listed_length; exact LE); fold Sth.
    change (dot (y_at (Datatypes.S i) k) (listed D de)) with (moved de (Datatypes.S i) k).
    replace (moved de (Datatypes.S i) k) with (moved y (Datatypes.S i) k - moved y' (Datatypes.S i) k) by apply moved_less.
    unfold gap; rewrite (proj2 (Nat.ltb_lt k n0) K); unfold zed.
    replace (fl y i k (tm y i) - (IZR (nth k (lz (leg_at (Datatypes.S i))) 0%Z) + moved y (Datatypes.S i) k) -
      (fl y' i k (tm y' i) - (IZR (nth k (lz (leg_at (Datatypes.S i))) 0%Z) + moved y' (Datatypes.S i) k)))
      with ((fl y i k (tm y i) - fl y' i k (tm y i)) + (fl y' i k (tm y i) - fl y' i k (tm y' i)) -
        (moved y (Datatypes.S i) k - moved y' (Datatypes.S i) k)) by ring.
    replace (fl y' i k (tm y i) - fl y' i k (tm y' i)) with ((th y i - th y' i) * G).
    + rewrite <- sth; ring.
    + rewrite <- Z2; unfold tm; fold L; now rewrite !Rmult_plus_distr_r.
  - rewrite !mult_IZR, !plus_IZR, !mult_IZR, <- INR_IZR_INZ; fold X e1 e2.
    apply Rle_trans with (1 := Rabs_triang _ _); rewrite Rabs_mult.
    assert (Rabs Sth * Rabs (G - IZR V) <= (IZR largest * c) * (X * e2 + 1)) by (apply Rmult_le_compat; auto using Rabs_pos; apply Mv).
    lra.
Qed.

Lemma entry_short : forall i, (i < M)%nat -> forall y y' c, 0 <= c -> (forall l, (l < D)%nat -> Rabs (y l - y' l) <= c) ->
  Rabs ((y (i * N + n0)%nat - y' (i * N + n0)%nat) - (gap y i n0 - gap y' i n0) / IZR (mu_at i n0)) <= c / 2.
Proof.
  intros i I y y' c c0 B; pose proof (proj2 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))) i) as H.
  unfold leg_ok in H; cbv zeta in H; rewrite !andb_true_iff in H; destruct H as [[_ [[Hs _] Le]] _]; apply Nat.eqb_eq in Le.
  refine (short_sound i n0 _ _ Hs I ltac:(unfold N; lia) (fun l => y l - y' l) c _ 0 c0 B _ ltac:(rewrite Rabs_R0; lra)).
  unfold gap; rewrite Nat.ltb_irrefl, dot_combine, dot_scale, Rplus_0_r; f_equal.
  set (e := lent (leg_at i)) in *; assert (Lf : length (firstn n0 e) = n0) by (rewrite firstn_length; lia).
  transitivity (dot (firstn n0 e) (listed n0 (moved (fun l => y l - y' l) i))); [|f_equal; unfold at_, listed; rewrite map_map; reflexivity].
  rewrite <- (dot_start_less _ _ _ _ Lf), dot_lcomb by (now rewrite !start_length).
  assert (Sp : forall y, dot e (start y i) = dot (firstn n0 e) (start y i) + dot (skipn n0 e) [IZR S]).
  { intro u; unfold start; rewrite <- (firstn_skipn n0 e) at 1; rewrite dot_app by (now rewrite listed_length).
    rewrite <- (app_nil_r (firstn n0 e)) at 2; rewrite dot_app by (now rewrite listed_length); cbn [dot]; ring. }
  rewrite !Sp; ring.
Qed.
Lemma near_zero : forall i, near N W (fl (fun _ => 0) i) 0 (lz (leg_at i)) 0.
Proof. intro i; apply near_start; [lia|]; intros; rewrite moved_0, Rabs_R0; lra. Qed.
Lemma gap_0 : forall i k, (k < N)%nat -> 2 * Rabs (gap (fun _ => 0) i k) <= IZR (mu_at i k) * IZR rho.
Proof.
  intros i k K; pose proof (proj2 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))) i) as H.
  unfold leg_ok in H; cbv zeta in H; rewrite !andb_true_iff in H; destruct H as [[[_ [[Hw _] Hs]] [[_ He] _]] _].
  apply Nat.eqb_eq in Hw; unfold gap; destruct (Nat.ltb_spec k n0) as [L|L].
  - rewrite forallb_forall in Hs; specialize (Hs k ltac:(apply in_seq; lia)).
    unfold state_ok in Hs; cbv zeta in Hs; apply andb_true_iff in Hs as [_ Hs]; apply Z.leb_le, IZR_le in Hs.
    rewrite !mult_IZR, plus_IZR, mult_IZR, abs_IZR, minus_IZR in Hs.
    pose proof (leg_about (fun _ => 0) i 0 ltac:(split; [lia|apply reach_nonneg]) ltac:(intros l _; rewrite Rabs_R0; now apply IZR_le)
      ltac:(intros; rewrite moved_0, Rabs_R0; lra) Hw k 0 K ltac:(rewrite Rabs_R0; lra)) as Q.
    rewrite Rabs_R0, Rmult_0_r, !Rplus_0_r in Q; unfold tm, th; rewrite moved_0; unfold Rdiv; rewrite Rmult_0_l, Rplus_0_r.
    unfold zed; rewrite moved_0, Rplus_0_r; set (a := fl _ i k _) in *; set (w := IZR (nth k (node _ _ _ _ _ _ _) 0%Z)) in *.
    set (b := IZR (nth k (lz _) 0%Z)) in *; replace (a - b) with ((a - w) + (w - b)) by ring; pose proof (Rabs_triang (a - w) (w - b)); lra.
  - assert (k = n0) as -> by (unfold N in K; lia); apply Z.leb_le, IZR_le in He; rewrite !mult_IZR, abs_IZR in He.
    destruct (near_zero i) as [Lz [_ Z0]].
    assert (E : at_once N (fl (fun _ => 0) i) 0 = start (fun _ => 0) i).
    { apply nth_ext with 0 0; unfold at_once; rewrite listed_length; [now rewrite start_length|].
      intros j J; unfold listed; rewrite nth_listed by exact J; now apply fl_start. }
    rewrite E in Z0; set (z := start _ i) in *.
    assert (Q : Rabs (dot (lent (leg_at i)) (less z (lz (leg_at i)))) <= 0).
    { rewrite <- (Rmult_0_r (IZR (row_size (lent (leg_at i))))); apply dot_size; [lra|]; intro j; specialize (Z0 j); lra. }
    rewrite <- dot_less in Q by (unfold z; rewrite start_length; congruence); apply abs_both in Q.
    replace (dot (lent (leg_at i)) z) with (IZR (zdot (lent (leg_at i)) (lz (leg_at i)))) by lra; exact He.
Qed.
Lemma closes : exists y, small_box y /\ forall i k, (i < M)%nat -> (k < N)%nat -> gap y i k = 0.
Proof.
  assert (mu0 : forall i k, (k < N)%nat -> 0 < IZR (mu_at i k)).
  { intros i k K; pose proof (proj2 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))) i) as H; apply IZR_lt.
    unfold leg_ok in H; cbv zeta in H; rewrite !andb_true_iff in H; destruct H as [[[_ [_ Hs]] [[He _] _]] _].
    destruct (Nat.eq_dec k n0) as [->|ne]; [unfold short in He; rewrite !andb_true_iff, Z.ltb_lt in He; apply He|].
    rewrite forallb_forall in Hs; specialize (Hs k ltac:(apply in_seq; unfold N in K; lia)).
    unfold state_ok, short in Hs; cbv zeta in Hs; rewrite !andb_true_iff, Z.ltb_lt in Hs; apply Hs. }
  assert (place : forall l, (l < D)%nat -> (l / N < M)%nat /\ (l mod N < N)%nat /\ (l / N * N + l mod N)%nat = l).
  { intros l L; assert (N <> O) by (unfold N; lia); split; [apply Nat.div_lt_upper_bound; unfold D in L; lia|].
    split; [now apply Nat.mod_upper_bound|]; rewrite (Nat.div_mod l N) at 3 by assumption; lia. }
  destruct (fixed_point D (fun y l => y l - gap y (l / N) (l mod N) / IZR (mu_at (l / N) (l mod N))) (IZR rho)) as [y [B E]].
  - now apply IZR_le.
  - intros y y' c c0 By By' B l L; destruct (place l L) as [I [K P]]; set (i := (l / N)%nat) in *; set (k := (l mod N)%nat) in *.
    replace (y l - gap y i k / IZR (mu_at i k) - (y' l - gap y' i k / IZR (mu_at i k)))
      with ((y l - y' l) - (gap y i k - gap y' i k) / IZR (mu_at i k)) by (field; apply Rgt_not_eq; now apply mu0).
    rewrite <- P; destruct (Nat.eq_dec k n0) as [->|ne]; [now apply entry_short|]; apply state_short; auto; unfold N in K; lia.
  - intros l L; destruct (place l L) as [I [K P]]; pose proof (gap_0 (l / N) (l mod N) K) as Q; pose proof (mu0 (l / N)%nat _ K) as mp.
    rewrite Rminus_0_l, Rabs_Ropp; unfold Rdiv at 1; rewrite Rabs_mult, (Rabs_right (/ _)) by (apply Rle_ge; left; now apply Rinv_0_lt_compat).
    apply (Rmult_le_reg_r (IZR (mu_at (l / N) (l mod N)))); [exact mp|]; rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra; lra.
  - exists y; split; [exact B|]; intros i k I K; assert (L : (i * N + k < D)%nat) by (unfold D; nia).
    specialize (E _ L); cbv beta in E; replace ((i * N + k) / N)%nat with i in E
      by (rewrite Nat.add_comm, Nat.div_add, Nat.div_small by (unfold N in *; lia); reflexivity).
    replace ((i * N + k) mod N)%nat with k in E by (rewrite Nat.add_comm, Nat.mod_add, Nat.mod_small by (unfold N in *; lia); reflexivity).
    pose proof (mu0 i k K) as mp; assert (E' : gap y i k / IZR (mu_at i k) = 0) by lra.
    apply (f_equal (fun v => v * IZR (mu_at i k))) in E'; unfold Rdiv in E'; rewrite Rmult_assoc, Rinv_l, Rmult_1_r, Rmult_0_l in E' by lra; exact E'.
Qed.

(* The solution, joined from its stays for ever. *)
Variable field : list R -> nat -> R.
Hypothesis field_on : forall i, (i < M)%nat -> forall z, length z = N -> nth n0 z 0 = IZR S ->
  (forall g, In g (lrows (leg_at i)) -> 0 <= dot g z) -> forall k, (k < n0)%nat ->
  dot (nth k (lA (leg_at i)) []) z / IZR (ld (leg_at i)) = field z k.

Theorem returns : exists x : nat -> R -> R,
  (forall t, 0 <= t -> x n0 t = IZR S) /\
  (forall k t, (k < n0)%nat -> 0 < t -> derivable_pt_lim (x k) t (field (at_once N x t) k)) /\
  forall i T, (i < M)%nat -> exists t, T <= t /\ forall k, (k < n0)%nat -> Rabs (x k t - IZR (nth k (lz (leg_at i)) 0%Z)) <= IZR reach.
Proof.
  destruct closes as [y [By Z]]; set (F := fun j => fl y (j mod M)); set (tau := fun j => tm y (j mod M)).
  assert (im : forall j, (j mod M < M)%nat) by (intro j; apply Nat.mod_upper_bound; lia).
  assert (next : forall j, (Datatypes.S (j mod M) mod M = Datatypes.S j mod M)%nat).
  { intro j; change (Datatypes.S (j mod M)) with (1 + j mod M)%nat; now rewrite Nat.add_mod_idemp_r by lia. }
  assert (nextz : forall j k, zed y (Datatypes.S (j mod M)) k = zed y (Datatypes.S j mod M) k).
  { intros j k; unfold zed, moved, y_at, leg_at; fold M; rewrite next, Nat.mod_mod by lia; reflexivity. }
  assert (nexts : forall j, start y (Datatypes.S (j mod M)) = start y (Datatypes.S j mod M)).
  { intro j; unfold start; f_equal; unfold listed; apply map_ext; intro k; apply nextz. }
  assert (nextl : forall j, leg_at (Datatypes.S (j mod M)) = leg_at (Datatypes.S j mod M)).
  { intro j; unfold leg_at; fold M; now rewrite next, Nat.mod_mod by lia. }
  assert (steps : forall i, 0 < hh i).
  { intro i; destruct (leg_facts i) as [d0 [p0 [q0 _]]]; unfold hh; apply Rdiv_lt_0_compat; [apply Rmult_lt_0_compat|]; now apply IZR_lt. }
  assert (dur : forall i, hh i / 2 <= tm y i <= INR (Datatypes.S (lK (leg_at i))) * hh i).
  { intro i; destruct (leg_facts i) as [_ [_ [_ [K1 _]]]]; destruct (th_box y By i) as [T1 T2]; pose proof (abs_both _ _ T1).
    apply le_INR in K1; cbn [INR] in K1; rewrite S_INR; unfold tm; pose proof (steps i); split; nra. }
  assert (least : exists e, 0 < e /\ forall j, e <= tau j).
  { assert (H : forall Q, exists e, 0 < e /\ forall r, (r < Q)%nat -> e <= tm y r).
    { induction Q as [|Q [e [e0 E]]]; [exists 1; split; [lra|intros; lia]|].
      exists (Rmin e (hh Q / 2)); split; [apply Rmin_pos; [exact e0|pose proof (steps Q); lra]|]; intros r L.
      destruct (Nat.eq_dec r Q) as [->|ne]; [apply Rle_trans with (1 := Rmin_r _ _); apply dur|apply Rle_trans with e; [apply Rmin_l|apply E; lia]]. }
    destruct (H M) as [e [e0 E]]; exists e; split; [exact e0|]; intro j; apply E, im. }
  destruct least as [e [e0 long]].
  assert (const : forall i t, fl y i n0 t = IZR S).
  { intros i; assert (D0 : forall t, derivable_pt_lim (fl y i n0) t 0).
    { intro t; destruct (leg_facts i) as [d0 [_ [_ [_ [_ [_ [Zr _]]]]]]].
      pose proof (fl_solves y i n0 t ltac:(unfold N; lia)) as Q; rewrite (dot_zero _ _ Zr) in Q; unfold Rdiv in Q; now rewrite Rmult_0_l in Q. }
    assert (S0 : fl y i n0 0 = IZR S) by (rewrite fl_start, start_nth, Nat.ltb_irrefl, Nat.eqb_refl by (unfold N; lia); reflexivity).
    intro t; rewrite <- S0; destruct (Rtotal_order t 0) as [L|[->|L]]; [|reflexivity|].
    - destruct (MVT_cor2 _ _ t 0 L (fun c _ => D0 c)) as [c [E _]]; lra.
    - destruct (MVT_cor2 _ _ 0 t L (fun c _ => D0 c)) as [c [E _]]; lra. }
  assert (begins : forall i, at_once N (fl y i) 0 = start y i).
  { intro i; apply nth_ext with 0 0; unfold at_once; rewrite listed_length; [now rewrite start_length|].
    intros j J; unfold listed; rewrite nth_listed by exact J; now apply fl_start. }
  assert (ends : forall j, at_once N (fl y (j mod M)) (tau j) = start y (Datatypes.S j mod M)).
  { intro j; apply nth_ext with 0 0; unfold at_once; rewrite listed_length; [now rewrite start_length|].
    intros k K; unfold listed; rewrite nth_listed, start_nth by exact K; destruct (Nat.ltb_spec k n0) as [L|L].
    - pose proof (Z (j mod M)%nat k (im j) K) as E; unfold gap in E; rewrite (proj2 (Nat.ltb_lt k n0) L), nextz in E; unfold tau; lra.
    - assert (k = n0) as -> by (unfold N in K; lia); rewrite Nat.eqb_refl; apply const. }
  assert (meets : forall j k, F j k (tau j) = F (Datatypes.S j) k 0).
  { intros j k; destruct (Nat.lt_ge_cases k N) as [K|K].
    - unfold F; rewrite fl_start, <- ends by exact K; unfold at_once, listed; now rewrite nth_listed.
    - assert (N0 : forall i t, fl y i k t = 0).
      { intros i t; unfold fl; generalize (start y i) O; induction l as [|v l IH]; intro r; cbn [blend]; [reflexivity|]; rewrite IH.
        assert (P0 : Phi i r k t = 0); [|rewrite P0; ring]; unfold Phi; apply (UL_sequence _ _ _ (sol_limit _ _ _ _ _ _)).
        assert (E : forall q, part_of (ld (leg_at i)) (lA (leg_at i)) (map IZR (spot N r S)) k q t = 0).
        { intro q; destruct (leg_facts i) as [_ [_ [_ [_ [LA _]]]]]; unfold part_of; rewrite nth_overflow; [ring|].
          rewrite powers_length; rewrite LA; [exact K|unfold spot; now rewrite !map_length, seq_length]. }
        apply (same_limit (fun _ => 0)); [intro q; unfold SP; induction q as [|q IHq]; cbn [sum_f_R0]; rewrite E; lra|].
        intros ep E0; exists O; intros q _; unfold R_dist; rewrite Rminus_0_r, Rabs_R0; exact E0. }
      unfold F; now rewrite !N0. }
  assert (entry : forall i, (i < M)%nat -> dot (lent (leg_at i)) (start y i) = 0).
  { intros i I; pose proof (Z i n0 I ltac:(unfold N; lia)) as E; unfold gap in E; now rewrite Nat.ltb_irrefl in E. }
  assert (stays_in : forall j s, 0 <= s <= tau j -> forall g, In g (lrows (leg_at (j mod M))) -> 0 <= dot g (at_once N (F j) s)).
  { intros j s I g G; set (i := (j mod M)%nat) in *; pose proof (proj2 (proj2 (proj2 (proj2 (proj2 (proj2 basics))))) i) as H.
    unfold leg_ok in H; cbv zeta in H; rewrite !andb_true_iff in H; destruct H as [[[_ [[Hw _] _]] _] Hk]; apply Nat.eqb_eq in Hw.
    rewrite forallb_forall in Hk; specialize (Hk g G).
    destruct (leg_facts i) as [d0 [p0 [q0 [K1 [LA [sm _]]]]]].
    assert (Hn : node (lA (leg_at i)) (lp (leg_at i)) (lq (leg_at i)) m (lK (leg_at i)) (lz (leg_at i)) reach <> [])
      by (intro E; rewrite E in Hw; discriminate).
    destruct (node_walk _ _ _ _ _ _ _ Hn) as [_ W2].
    apply (keeps_sound N (ld (leg_at i)) (lA (leg_at i)) W (lp (leg_at i)) (lq (leg_at i)) d0 p0 q0 LA LW w1 sm (fl y i) m (fl_solves y i)
      g (tau j) (touches g (lent (leg_at (Datatypes.S i)))) (Datatypes.S (lK (leg_at i))) 0 (lz (leg_at i)) reach reach
      (touches g (lent (leg_at i))) (near_start y i reach reach_nonneg ltac:(intros; now apply moved_box)) (Z.le_refl _) W2 Hk); try discriminate.
    - intro T; rewrite begins; rewrite (touches_0 _ _ _ T (entry i (im j))); lra.
    - intro T; unfold i in T |- *; rewrite ends; rewrite nextl in T; rewrite (touches_0 _ _ _ T (entry _ (im (Datatypes.S j)))); lra.
    - rewrite Rplus_0_l; apply dur.
    - exact I. }
  assert (flow : forall j k s, (k < n0)%nat -> 0 <= s <= tau j -> derivable_pt_lim (F j k) s (field (at_once N (F j) s) k)).
  { intros j k s K I; rewrite <- (field_on (j mod M)%nat (im j)); [apply fl_solves; unfold N; lia|apply listed_length| |now apply stays_in|exact K].
    unfold at_once, listed; rewrite nth_listed by (unfold N; lia); apply const. }
  exists (joined tau e F); split; [|split].
  - intros t T; apply const.
  - intros k t K T; destruct (index_spec tau e e0 long t) as [A B]; set (j := index tau e t) in *.
    destruct (Req_dec t (jump tau j)) as [E|E].
    + assert (X : exists i, j = Datatypes.S i).
      { exists (pred j); assert (j <> O); [|lia]; intro J; rewrite J in E; cbn in E; lra. }
      destruct X as [i X]; rewrite E, X.
      assert (At : at_once N (joined tau e F) (jump tau (Datatypes.S i)) = at_once N (F (Datatypes.S i)) 0).
      { unfold at_once, listed; apply map_ext; intro r; now apply joined_at. }
      rewrite At; pose proof (long i); pose proof (long (Datatypes.S i)); apply joined_turns; auto; [|apply flow; [exact K|lra]].
      replace (at_once N (F (Datatypes.S i)) 0) with (at_once N (F i) (tau i)); [apply flow; [exact K|lra]|].
      unfold at_once, listed; apply map_ext; intro r; apply meets.
    + assert (A' : jump tau j <= t) by (destruct A as [A|A]; [rewrite A in *; cbn; lra|exact A]).
      apply joined_derivable; auto.
      * intros r R0; apply E; unfold j; rewrite R0; rewrite (index_in tau e e0 long (Datatypes.S r)); [reflexivity|right; lra|].
        pose proof (long (Datatypes.S r)); cbn [jump]; lra.
      * fold j; change (at_once N (joined tau e F) t) with (at_once N (F j) (t - jump tau j)); apply flow; [exact K|cbn [jump] in B; lra].
  - intros i T I; destruct (archimed (Rabs T / e)) as [U _]; set (q := Z.to_nat (up (Rabs T / e))); set (j := (i + q * M)%nat).
    assert (Ej : (j mod M = i)%nat) by (unfold j; rewrite Nat.mod_add, Nat.mod_small by lia; reflexivity).
    exists (jump tau j); split.
    + pose proof (jump_later tau e long 0 j ltac:(lia)) as L; rewrite Nat.sub_0_r in L; cbn [jump] in L.
      assert (P : 0 <= Rabs T / e) by (apply Rmult_le_pos; [apply Rabs_pos|left; now apply Rinv_0_lt_compat]).
      assert (Q : Rabs T / e < INR q) by (unfold q; rewrite INR_IZR_INZ, Z2Nat.id; [exact U|apply le_IZR; lra]).
      assert (INR q <= INR j) by (apply le_INR; unfold j; nia); pose proof (Rle_abs T).
      apply (Rmult_lt_compat_r e) in Q; [|exact e0]; replace (Rabs T / e * e) with (Rabs T) in Q by (field; lra); nra.
    + intros k K; rewrite joined_at by assumption; unfold F; rewrite Ej, fl_start, start_nth, (proj2 (Nat.ltb_lt k n0) K) by (unfold N; lia).
      unfold zed; replace (IZR (nth k (lz (leg_at i)) 0%Z) + moved y i k - IZR (nth k (lz (leg_at i)) 0%Z)) with (moved y i k) by ring.
      now apply moved_box.
Qed.

End Orbit.

(* Each of two values is passed again and again. *)
Lemma never_settles : forall (f : R -> R) (a b r s : Z), (0 < s)%Z -> (2 * r < Z.abs (a - b))%Z ->
  (forall T, exists t, T <= t /\ Rabs (f t - IZR a) <= IZR r) -> (forall T, exists t, T <= t /\ Rabs (f t - IZR b) <= IZR r) ->
  forall c, ~ tends_to (fun t => f t / IZR s) c.
Proof.
  intros f a b r s sp L A B c lim; apply IZR_lt in sp, L; rewrite mult_IZR, abs_IZR, minus_IZR in L.
  assert (e0 : 0 < (Rabs (IZR a - IZR b) - 2 * IZR r) / 2 / IZR s) by (apply Rdiv_lt_0_compat; lra).
  destruct (lim _ e0) as [T H].
  assert (K : forall t, t >= T -> Rabs (f t - IZR s * c) < (Rabs (IZR a - IZR b) - 2 * IZR r) / 2).
  { intros t Q; specialize (H t Q); replace (f t - IZR s * c) with ((f t / IZR s - c) * IZR s) by (field; lra).
    rewrite Rabs_mult, (Rabs_right (IZR s)) by lra; apply (Rmult_lt_compat_r (IZR s)) in H; [|exact sp].
    replace ((Rabs (IZR a - IZR b) - 2 * IZR r) / 2) with ((Rabs (IZR a - IZR b) - 2 * IZR r) / 2 / IZR s * IZR s) by (field; lra); exact H. }
  destruct (A T) as [u [U1 U2]]; destruct (B T) as [v [V1 V2]]; pose proof (K u ltac:(lra)) as Ku; pose proof (K v ltac:(lra)) as Kv.
  set (e := IZR s * c) in *; set (x := IZR a) in *; set (y := IZR b) in *.
  assert (E : Rabs (x - y) <= Rabs (f u - x) + Rabs (f u - e) + Rabs (f v - e) + Rabs (f v - y)); [|lra].
  replace (x - y) with (- (f u - x) + ((f u - e) + (- (f v - e) + (f v - y)))) by ring.
  pose proof (Rabs_triang (- (f u - x)) ((f u - e) + (- (f v - e) + (f v - y)))) as X1.
  pose proof (Rabs_triang (f u - e) (- (f v - e) + (f v - y))) as X2; pose proof (Rabs_triang (- (f v - e)) (f v - y)) as X3.
  rewrite Rabs_Ropp in X1, X3; lra.
Qed.
